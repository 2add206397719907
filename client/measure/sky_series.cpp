#include "measure/sky_series.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "measure/fault.h"
#include "measure/measured.h"
#include "measure/weather_file.h"
#include "photometry/sky/cie_sky.h"
#include "wire/sky_light.h"

namespace tessera::client {

namespace {

constexpr std::size_t kMostSteps = 1000;

/// The number of the scene's only sky.
absl::StatusOr<int> only_sky(const v1::Scene& scene) {
  std::optional<int> found;
  int skies = 0;
  for (int i = 0; i < scene.lights_size(); ++i) {
    if (!scene.lights(i).has_sky()) continue;
    found = i;
    ++skies;
  }
  if (skies == 1) return *found;
  return fault(skies == 0 ? std::string("the scene has no `sky` light, which it would replace")
                          : absl::StrCat("the scene has ", skies, " `sky` lights: it replaces one"));
}

/// Adds a step, of a black sky where the sun is down.
absl::Status add_step(double value, std::string word, v1::SkyLight sky, SkySteps& series) {
  const auto sun = wire::sun_altitude_degrees(sky);
  if (!sun.ok()) return sun.status();
  const double altitude = sun->value_or(std::numeric_limits<double>::quiet_NaN());
  SkyStep step{
      .value = value, .word = std::move(word), .sun_altitude_degrees = altitude, .sky = std::move(sky)};
  if (altitude <= 0) {
    step.word = kNightWord;
    step.sky.mutable_perez()->Clear();
    step.sky.clear_diffuse_horizontal_illuminance(), step.sky.clear_sun_normal_illuminance();
  }
  if (const auto whole = wire::sky_of(step.sky); !whole.ok())
    return fault(absl::StrCat(series.name, " ", value, ": ", whole.status().message()));
  series.steps.push_back(std::move(step));
  return absl::OkStatus();
}

absl::Status add_hours(const v1::SkySeries::HoursOfDay& hours, const v1::SkyLight& sky, SkySteps& series) {
  series.name = "hour";
  if (!sky.has_when())
    return fault("the scene's sky does not say `when` it is: hours are of a place and a day");
  const double first = hours.first(), last = hours.has_last() ? hours.last() : 23,
               step = hours.has_step() ? hours.step() : 1;
  if (!(first >= 0 && last <= 24 && first <= last))
    return fault(absl::StrCat("hours go from first to last within 0 and 24, not from ", first, " to ", last));
  if (!(step > 0)) return fault(absl::StrCat("step ", step, " is not above 0"));
  // A sum of steps may be rounded to beyond the last hour.
  const double steps = std::floor((last - first) / step * (1 + 1e-12)) + 1;
  if (!(steps <= kMostSteps)) return fault(absl::StrCat("it has more than ", kMostSteps, " steps"));
  for (int i = 0; i < static_cast<int>(steps); ++i) {
    v1::SkyLight now = sky;
    const double hour = std::min(last, first + i * step);
    now.mutable_when()->set_hour(hour);
    if (absl::Status s = add_step(hour, "day", std::move(now), series); !s.ok()) return s;
  }
  return absl::OkStatus();
}

absl::Status add_types(const v1::SkySeries::CieTypes& asked, const v1::SkyLight& sky, SkySteps& series) {
  series.name = "cie_type";
  std::vector<std::uint32_t> types(asked.types().begin(), asked.types().end());
  if (types.size() > kMostSteps) return fault(absl::StrCat("it has more than ", kMostSteps, " steps"));
  for (std::uint32_t type = 1; asked.types().empty() && type <= photometry::kCieSkies; ++type)
    types.push_back(type);
  for (const std::uint32_t type : types) {
    if (type < 1 || type > photometry::kTraditionalOvercast)
      return fault(absl::StrCat("CIE types are 1 to 16, not ", type));
    v1::SkyLight now = sky;
    now.set_cie_type(type);
    if (absl::Status s =
            add_step(type, photometry::cie_sky_name(static_cast<int>(type)), std::move(now), series);
        !s.ok())
      return s;
  }
  return absl::OkStatus();
}

/// The sky of an hour of a weather file.
absl::StatusOr<v1::SkyLight> weather_sky(const photometry::Weather& weather,
                                         const photometry::WeatherHour& hour, v1::SkyLight sky) {
  const photometry::ClockTime middle = photometry::middle_of(weather, hour);
  v1::SkyLight::PlaceAndTime& when = *sky.mutable_when();
  when.set_latitude_degrees(weather.place.latitude_degrees);
  when.set_longitude_degrees(weather.place.longitude_degrees);
  when.set_utc_offset_hours(middle.utc_offset_hours);
  when.set_year(middle.year), when.set_hour(middle.hour);
  when.set_month(static_cast<std::uint32_t>(middle.month));
  when.set_day(static_cast<std::uint32_t>(middle.day));
  sky.clear_diffuse_horizontal_illuminance(), sky.clear_sun_normal_illuminance();
  v1::SkyLight::Perez& perez = *sky.mutable_perez();
  perez.Clear();
  const auto sun = wire::sun_altitude_degrees(sky);
  if (!sun.ok()) return sun.status();
  const double altitude = sun->value();  // `when` says it
  if (altitude <= 0) return sky;
  const auto measured = photometry::irradiances_of(hour, altitude);
  if (!measured)
    return fault(
        absl::StrCat("hour ", hour.hour, ": the weather file has no radiation of it (line ", hour.line, ")"));
  perez.set_direct_normal_irradiance(measured->direct_normal);
  perez.set_diffuse_horizontal_irradiance(measured->diffuse_horizontal);
  if (hour.dew_point_celsius) perez.set_dew_point_celsius(*hour.dew_point_celsius);
  return sky;
}

absl::Status add_weather(const v1::SkySeries::WeatherHours& asked, const photometry::Weather& weather,
                         const v1::SkyLight& sky, SkySteps& series) {
  series.name = "hour";
  const std::uint32_t first = asked.has_first_hour() ? asked.first_hour() : 1,
                      last = asked.has_last_hour() ? asked.last_hour() : 24;
  if (!(first >= 1 && last <= 24 && first <= last))
    return fault(
        absl::StrCat("hours of weather files go from first_hour to last_hour within 1 and 24, not from ",
                     first, " to ", last));
  const std::uint32_t month = asked.month() > 0 ? asked.month() : sky.when().month(),
                      day = asked.day() > 0 ? asked.day() : sky.when().day();
  for (const photometry::WeatherHour& hour : weather.hours) {
    const auto number = static_cast<std::uint32_t>(hour.hour);
    if (static_cast<std::uint32_t>(hour.month) != month || static_cast<std::uint32_t>(hour.day) != day ||
        number < first || number > last)
      continue;
    auto now = weather_sky(weather, hour, sky);
    if (!now.ok()) return now.status();
    if (absl::Status s = add_step(hour.hour, "all-weather", *std::move(now), series); !s.ok()) return s;
  }
  if (series.steps.empty())
    return fault(absl::StrCat("the weather file has no such day: month ", month, ", day ", day));
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<SkySteps> sky_steps(const MeterFile& file, const ImportedScene& scene) {
  std::vector<std::pair<std::size_t, std::string>> faults;
  for (int i = 0; i < file.list.meters_size(); ++i) {
    if (file.list.meters(i).has_annual_daylight())
      faults.emplace_back(static_cast<std::size_t>(i), "a year has skies of its own: it goes with no series");
  }
  if (absl::Status s = file.status_of(faults); !s.ok()) return s;
  const auto light = only_sky(scene.scene);
  if (!light.ok()) return file.fault_of_series(std::string(light.status().message()));
  SkySteps series;
  series.light = *light;
  const v1::SkySeries& asked = file.list.series();
  const v1::SkyLight& sky = scene.scene.lights(*light).sky();
  absl::Status added;
  switch (asked.steps_case()) {
    case v1::SkySeries::kHours:
      added = add_hours(asked.hours(), sky, series);
      break;
    case v1::SkySeries::kCieTypes:
      added = add_types(asked.cie_types(), sky, series);
      break;
    case v1::SkySeries::kWeather: {
      const auto folder = std::filesystem::path(file.path).parent_path();
      const auto weather = read_weather((folder / asked.weather().weather_file()).string());
      if (!weather.ok()) return weather.status();
      added = add_weather(asked.weather(), *weather, sky, series);
      break;
    }
    case v1::SkySeries::STEPS_NOT_SET:
      added = fault("it says nothing of its steps: hours, cie_types or weather");
      break;
  }
  if (!added.ok()) return file.fault_of_series(std::string(added.message()));
  return series;
}

}  // namespace tessera::client
