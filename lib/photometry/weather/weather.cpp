#include "photometry/weather/weather.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "photometry/sun/sun_irradiance.h"

namespace tessera::photometry {
namespace {

constexpr double kUsualDewPoint = 11;
/// Below this altitude the model is not fitted, and little light comes.
constexpr double kLowestSunDegrees = 0;

}  // namespace

std::string missing_values(const Weather& weather) {
  std::vector<std::string> told;
  for (std::size_t i = 0; i < weather.missing.size(); ++i) {
    const int hours = weather.missing[i];
    if (hours > 0)
      told.push_back(
          absl::StrCat(kWeatherFieldNames[i], " is missing in ", hours, hours == 1 ? " hour" : " hours"));
  }
  return absl::StrJoin(told, ", ");
}

ClockTime middle_of(const Weather& weather, const WeatherHour& hour) {
  return {.year = hour.year,
          .month = hour.month,
          .day = hour.day,
          .hour = hour.hour - 0.5,
          .utc_offset_hours = weather.utc_offset_hours};
}

std::optional<Irradiances> irradiances_of(const WeatherHour& hour, double sun_altitude_degrees) {
  if (hour.direct_normal && hour.diffuse_horizontal)
    return Irradiances{*hour.direct_normal, *hour.diffuse_horizontal};
  if (!hour.global_horizontal) return std::nullopt;
  const double sine = std::sin(sun_altitude_degrees * kRadiansPerDegree);
  if (hour.direct_normal) {
    const double diffuse = *hour.global_horizontal - *hour.direct_normal * std::max(sine, 0.0);
    return Irradiances{*hour.direct_normal, std::max(diffuse, 0.0)};
  }
  if (hour.diffuse_horizontal && sine > 0)
    return Irradiances{std::max((*hour.global_horizontal - *hour.diffuse_horizontal) / sine, 0.0),
                       *hour.diffuse_horizontal};
  return std::nullopt;
}

WeatherSky sky_of(const Weather& weather, const WeatherHour& hour, double ground_reflectance) {
  WeatherSky result;
  result.sun = sun_position(weather.place, middle_of(weather, hour));
  if (!(result.sun.altitude_degrees > kLowestSunDegrees)) return result;
  const auto measured = irradiances_of(hour, result.sun.altitude_degrees);
  if (!measured) {
    result.has_data = false;
    return result;
  }
  const double zenith = (90 - result.sun.altitude_degrees) * kRadiansPerDegree;
  const PerezWeather state =
      perez_weather(*measured, zenith, extraterrestrial_irradiance(result.sun.distance_au));
  const Daylight daylight =
      perez_daylight(*measured, state, zenith, hour.dew_point_celsius.value_or(kUsualDewPoint));
  result.sky = make_sky(perez_pattern(state, zenith), result.sun.toward, daylight, ground_reflectance);
  return result;
}

}  // namespace tessera::photometry
