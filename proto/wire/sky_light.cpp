#include "wire/sky_light.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "photometry/sky/cie_sky.h"
#include "photometry/sky/perez_sky.h"
#include "photometry/sun/sun_irradiance.h"
#include "photometry/sun/sun_position.h"

namespace tessera::wire {
namespace {

constexpr double kMeanSunDegrees = 0.533;
constexpr double kLeastSunDegrees = 0.01, kMostSunDegrees = 90;
constexpr double kUsualReflectance = 0.2, kUsualDewPoint = 11;
constexpr int kUsualResolution = 512, kLeastResolution = 8, kMostResolution = 4096;

absl::Status refuse(const char* field, double value, const char* allowed) {
  return absl::InvalidArgumentError(absl::StrCat(field, " ", value, " is not ", allowed));
}

bool is_amount(double value) { return value >= 0 && std::isfinite(value); }

absl::Status check_amounts(const v1::SkyLight& light) {
  constexpr const char* kAmount = "a finite number at or above 0";
  if (!is_amount(light.diffuse_horizontal_illuminance()))
    return refuse("diffuse_horizontal_illuminance", light.diffuse_horizontal_illuminance(), kAmount);
  if (!is_amount(light.sun_normal_illuminance()))
    return refuse("sun_normal_illuminance", light.sun_normal_illuminance(), kAmount);
  if (!light.has_perez()) return absl::OkStatus();
  const v1::SkyLight::Perez& perez = light.perez();
  if (!is_amount(perez.direct_normal_irradiance()))
    return refuse("direct_normal_irradiance", perez.direct_normal_irradiance(), kAmount);
  if (!is_amount(perez.diffuse_horizontal_irradiance()))
    return refuse("diffuse_horizontal_irradiance", perez.diffuse_horizontal_irradiance(), kAmount);
  if (const double dew_point = perez.dew_point_celsius(); !(dew_point >= -90 && dew_point <= 70))
    return refuse("dew_point_celsius", dew_point, "within -90 and 70");
  return absl::OkStatus();
}

absl::Status check_numbers(const v1::SkyLight& light) {
  if (auto s = check_amounts(light); !s.ok()) return s;
  if (!(light.ground_reflectance() >= 0 && light.ground_reflectance() <= 1))
    return refuse("ground_reflectance", light.ground_reflectance(), "within 0 and 1");
  if (const double across = sun_degrees(light);
      across != 0 && !(across >= kLeastSunDegrees && across <= kMostSunDegrees))
    return refuse("sun_degrees", across, "0 (parallel light) or within 0.01 and 90");
  if (!std::isfinite(light.north_degrees())) return refuse("north_degrees", light.north_degrees(), "finite");
  if (const std::uint32_t size = light.resolution();
      size != 0 && (size < kLeastResolution || size > kMostResolution))
    return refuse("resolution", size, "0 (512) or within 8 and 4096");
  return absl::OkStatus();
}

struct Sun {
  photometry::HorizonDirection toward;
  double distance_au = 1;

  double altitude_degrees() const { return photometry::altitude_degrees(toward); }
};

/// Nothing where the message does not say where the sun is.
absl::StatusOr<std::optional<Sun>> sun_of(const v1::SkyLight& light) {
  if (light.has_toward_sun()) {
    const v1::Point3& p = light.toward_sun();
    const double length = std::hypot(p.x(), p.y(), p.z());
    if (!(length > 0) || !std::isfinite(length))
      return absl::InvalidArgumentError("toward_sun has no direction");
    return Sun{.toward = horizon_of(light).horizon_from_world({p.x(), p.y(), p.z()})};
  }
  if (!light.has_when()) return std::nullopt;
  const v1::SkyLight::PlaceAndTime& when = light.when();
  const photometry::Place place{when.latitude_degrees(), when.longitude_degrees()};
  const photometry::ClockTime time{.year = when.year(),
                                   .month = static_cast<int>(std::min(when.month(), 99u)),
                                   .day = static_cast<int>(std::min(when.day(), 99u)),
                                   .hour = when.hour(),
                                   .utc_offset_hours = when.utc_offset_hours()};
  if (auto s = photometry::check_place(place); !s.ok()) return s;
  if (auto s = photometry::check_time(time); !s.ok()) return s;
  const photometry::SunPosition sun = photometry::sun_position(place, time);
  return Sun{sun.toward, sun.distance_au};
}

absl::Status sun_is_down(const Sun& sun, const std::string& why) {
  return absl::InvalidArgumentError(absl::StrCat("the sun is ", -sun.altitude_degrees(),
                                                 " degrees below the horizon there and then; ", why));
}

/// Replacements of a model's own values.
void take_given(const v1::SkyLight& light, photometry::Daylight& daylight) {
  if (light.has_diffuse_horizontal_illuminance())
    daylight.diffuse_horizontal = light.diffuse_horizontal_illuminance();
  if (light.has_sun_normal_illuminance()) daylight.sun_normal = light.sun_normal_illuminance();
}

double reflectance_of(const v1::SkyLight& light) {
  return light.has_ground_reflectance() ? light.ground_reflectance() : kUsualReflectance;
}

absl::StatusOr<photometry::Sky> cie_sky(const v1::SkyLight& light, const std::optional<Sun>& sun) {
  const int type = static_cast<int>(std::min(light.cie_type(), 1000u));
  auto pattern = photometry::cie_pattern(type);
  if (!pattern.ok()) return pattern.status();
  // Typical amounts are those of the sun's altitude.
  const bool is_typical = !light.has_diffuse_horizontal_illuminance() ||
                          (!light.has_sun_normal_illuminance() && type >= 7 && type <= 15);
  const std::string sky = absl::StrCat("a CIE sky of type ", type);
  if (photometry::cie_sky_needs_sun(type) || is_typical || has_sun(light)) {
    const char* const reason = photometry::cie_sky_needs_sun(type) ? "has its pattern about the sun"
                               : is_typical ? "is as bright as is typical for the sun's altitude"
                                            : "has a sun";
    if (!sun) {
      return absl::InvalidArgumentError(
          absl::StrCat(sky, " ", reason, ": it needs toward_sun, or a place and time (when)"));
    }
    if (!(sun->toward.up > 0)) return sun_is_down(*sun, absl::StrCat(sky, " ", reason));
  }
  photometry::Daylight daylight;
  if (is_typical) {
    const auto typical = photometry::typical_daylight(type, sun->altitude_degrees(), sun->distance_au);
    if (!typical.ok()) return typical.status();
    daylight = *typical;
  }
  take_given(light, daylight);
  return photometry::make_sky(*pattern, sun.value_or(Sun{}).toward, daylight, reflectance_of(light));
}

absl::StatusOr<photometry::Sky> perez_sky(const v1::SkyLight& light, const std::optional<Sun>& sun) {
  if (!sun) return absl::InvalidArgumentError("a Perez sky needs toward_sun, or a place and time (when)");
  const v1::SkyLight::Perez& perez = light.perez();
  const photometry::Irradiances measured{perez.direct_normal_irradiance(),
                                         perez.diffuse_horizontal_irradiance()};
  photometry::Daylight daylight;
  if (!(sun->toward.up > 0)) {
    take_given(light, daylight);
    // Nights are black.
    if (measured.direct_normal == 0 && measured.diffuse_horizontal == 0 && daylight.diffuse_horizontal == 0 &&
        daylight.sun_normal == 0)
      return photometry::Sky{.sun = sun->toward};
    return sun_is_down(*sun, "a Perez sky that is not black needs one above");
  }
  const double zenith = (90 - sun->altitude_degrees()) * photometry::kRadiansPerDegree;
  const photometry::PerezWeather weather =
      photometry::perez_weather(measured, zenith, photometry::extraterrestrial_irradiance(sun->distance_au));
  daylight = photometry::perez_daylight(
      measured, weather, zenith, perez.has_dew_point_celsius() ? perez.dew_point_celsius() : kUsualDewPoint);
  take_given(light, daylight);
  return photometry::make_sky(photometry::perez_pattern(weather, zenith), sun->toward, daylight,
                              reflectance_of(light));
}

}  // namespace

WorldHorizon::Vector WorldHorizon::world_from_horizon(const photometry::HorizonDirection& w) const {
  Vector v;
  for (std::size_t i = 0; i < 3; ++i) v[i] = east[i] * w.east + north[i] * w.north + up[i] * w.up;
  return v;
}

photometry::HorizonDirection WorldHorizon::horizon_from_world(const Vector& v) const {
  const double length = std::hypot(v[0], v[1], v[2]);
  const auto along = [&](const Vector& axis) {
    return (axis[0] * v[0] + axis[1] * v[1] + axis[2] * v[2]) / length;
  };
  return {along(east), along(north), along(up)};
}

WorldHorizon horizon_of(const v1::SkyLight& light) {
  const double turn = std::fmod(light.north_degrees(), 360.0) * photometry::kRadiansPerDegree;
  const double c = std::cos(turn), s = std::sin(turn);
  if (light.y_up()) return {.east = {c, 0, s}, .north = {s, 0, -c}, .up = {0, 1, 0}};
  return {.east = {c, -s, 0}, .north = {s, c, 0}, .up = {0, 0, 1}};
}

bool has_sun(const v1::SkyLight& light) {
  if (light.has_sun_normal_illuminance()) return light.sun_normal_illuminance() > 0;
  if (light.has_perez()) return light.perez().direct_normal_irradiance() > 0;
  return light.cie_type() >= 7 && light.cie_type() <= 15;
}

absl::StatusOr<photometry::Sky> sky_of(const v1::SkyLight& light) {
  if (auto s = check_numbers(light); !s.ok()) return s;
  const auto sun = sun_of(light);
  if (!sun.ok()) return sun.status();
  switch (light.model_case()) {
    case v1::SkyLight::kCieType:
      return cie_sky(light, *sun);
    case v1::SkyLight::kPerez:
      return perez_sky(light, *sun);
    case v1::SkyLight::MODEL_NOT_SET:
      break;
  }
  return absl::InvalidArgumentError("a sky needs a model: cie_type, or perez");
}

absl::StatusOr<std::optional<double>> sun_altitude_degrees(const v1::SkyLight& light) {
  const auto sun = sun_of(light);
  if (!sun.ok()) return sun.status();
  return *sun ? std::optional((*sun)->altitude_degrees()) : std::nullopt;
}

double sun_degrees(const v1::SkyLight& light) {
  return light.has_sun_degrees() ? light.sun_degrees() : kMeanSunDegrees;
}

int sky_resolution(const v1::SkyLight& light) {
  return light.resolution() == 0 ? kUsualResolution : static_cast<int>(light.resolution());
}

}  // namespace tessera::wire
