// Weather files of EnergyPlus, and the skies of their hours.
#include <cmath>

#include "fuzz/target.h"
#include "photometry/weather/epw.h"

namespace tessera::fuzz {
namespace {

/// A day of hours is enough of a file: a whole year would be half a megabyte of numbers that are alike. What
/// is wrong with such a file is that the rest of the year is missing.
constexpr std::size_t kHoursOfDay = 24;

bool accepts_weather(std::string_view bytes) {
  const std::vector<char> input = exact(bytes);
  std::vector<photometry::WeatherFault> faults;
  const photometry::Weather weather = photometry::read_epw({input.data(), input.size()}, faults);
  for (const photometry::WeatherFault& fault : faults) {
    require(!fault.message.empty(), "an error without a message");
    require(fault.line >= 1 && fault.column >= 1, "an error without a place");
  }
  require(!faults.empty() || weather.hours.size() >= 8760, "hours are missing, and nothing says so");
  for (const photometry::WeatherHour& hour : weather.hours) {
    require(photometry::check_time(photometry::middle_of(weather, hour)).ok(), "an hour of no day");
    const photometry::WeatherSky now = photometry::sky_of(weather, hour);
    if (!now.sky) continue;
    require(std::isfinite(now.sky->luminance_scale) && now.sky->luminance_scale >= 0,
            "a sky of no luminance");
    require(std::isfinite(now.sky->sun_normal_illuminance), "a sun of no illuminance");
  }
  return faults.size() == 1 && weather.hours.size() >= kHoursOfDay;
}

}  // namespace

const Target kWeather = {"weather", accepts_weather};

}  // namespace tessera::fuzz
