// The weather of a year, hour by hour.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "photometry/sky/perez_sky.h"
#include "photometry/sky/sky.h"
#include "photometry/sun/sun_position.h"

namespace tessera::photometry {

/// The hour that ends at `hour` by the clock of the place. What the file has no value of is absent.
struct WeatherHour {
  int year = 0, month = 0, day = 0, hour = 0;  // hour: 1 to 24
  int line = 0;                                // of the file, from 1
  std::optional<double> dew_point_celsius = {};
  std::optional<double> global_horizontal = {}, direct_normal = {},
                        diffuse_horizontal = {};  // irradiances, W/m^2
};

/// Fields of WeatherHour that may be missing.
inline constexpr int kWeatherFields = 4;
inline constexpr std::array<const char*, kWeatherFields> kWeatherFieldNames = {
    "dew point temperature", "global horizontal radiation", "direct normal radiation",
    "diffuse horizontal radiation"};

struct Weather {
  std::string city, region, country;
  Place place;
  double utc_offset_hours = 0;
  double elevation_metres = 0;
  std::vector<WeatherHour> hours;                // in the order of the file
  std::array<int, kWeatherFields> missing = {};  // hours without a value, by field
};

/// "direct normal radiation is missing in 12 hours, ...": what is to be said of a file that was read; empty
/// where every hour has everything.
std::string missing_values(const Weather& weather);

/// The middle of an hour.
ClockTime middle_of(const Weather& weather, const WeatherHour& hour);

/// Irradiances of an hour whose sun is at an altitude; where one of the three that a file has is missing, it
/// follows from the others (global = diffuse + direct times the sine of the altitude). Nothing where two are.
std::optional<Irradiances> irradiances_of(const WeatherHour& hour, double sun_altitude_degrees);

/// An hour in the terms of the model of Perez.
struct WeatherSky {
  SunPosition sun;
  std::optional<Sky> sky;  // nothing: night
  bool has_data = true;    // false: it is day, and irradiances are missing
};

/// The sky of the middle of an hour [Perez1993], over a ground of some reflectance. Hours whose middle is
/// night have none. Where its dew point is missing, 11 degrees Celsius stand for it.
WeatherSky sky_of(const Weather& weather, const WeatherHour& hour, double ground_reflectance = 0.2);

}  // namespace tessera::photometry
