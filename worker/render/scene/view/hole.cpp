#include "render/scene/view/hole.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "optics/hole_diffraction.h"
#include "spectra/sensor/sensor_name.h"
#include "wire/film_format.h"

namespace tessera::render {

namespace {

using spectra::kLeastSensorNm, spectra::kMostSensorNm;

constexpr double kMiddleOfLightNm = 550, kMmInNm = 1e-6;

/// How many wavelengths have a pattern of their own; between them, radii are on straight lines. The pattern
/// grows by the wavelength where the Fresnel number is low, and hardly depends on it where that is high, but
/// takes longer to compute.
int patterns_for(double fresnel_number) {
  constexpr double kLow = 20, kHigh = 50;
  if (fresnel_number < kLow) return 36;
  return fresnel_number < kHigh ? 24 : 8;
}

void add_pattern(double fresnel_number, HoleTable& table) {
  // Farther out, rings are so close that their mean stands for them.
  constexpr double kShadows = 1.5, kWaves = 10;
  const double reach = std::max(kShadows, kWaves / fresnel_number);
  std::vector<double> radii;
  for (int i = 1; i <= kHoleNearSteps; ++i) radii.push_back(reach * i / kHoleNearSteps);
  const bool is_shadow = fresnel_number > optics::kMostFresnelNumber;
  std::vector<double> parts;
  if (!is_shadow) parts = optics::light_within_hole(fresnel_number, radii);
  table.reach.push_back(static_cast<float>(reach));
  table.light.push_back(0);
  for (std::size_t i = 0; i < radii.size(); ++i)
    table.light.push_back(static_cast<float>(is_shadow ? std::min(radii[i] * radii[i], 1.0) : parts[i]));
  for (int i = 1; i <= kHoleFarSteps; ++i) {
    const double inverse = static_cast<double>(kHoleFarSteps - i) / kHoleFarSteps;
    const bool has_all = is_shadow || i == kHoleFarSteps;
    table.light.push_back(
        static_cast<float>(has_all ? 1 : 1 - optics::light_beyond_hole(fresnel_number, reach / inverse)));
  }
}

}  // namespace

absl::Status check_hole(const v1::PinholeCamera& camera) {
  std::vector<std::string> faults;
  constexpr double kLeastMm = 1e-4, kMostMm = 1e5;
  const auto check_length = [&](double mm, const char* what) {
    if (!(mm >= kLeastMm && mm <= kMostMm))
      faults.push_back(
          absl::StrCat(what, " of ", mm, " mm is not possible; ", kLeastMm, " to ", kMostMm, " mm are"));
  };
  check_length(camera.hole_mm(), "a hole");
  check_length(camera.film_distance_mm(), "a distance of the film");
  if (camera.hole_mm() > camera.film_distance_mm() && camera.film_distance_mm() > 0)
    faults.push_back(absl::StrCat("a hole of ", camera.hole_mm(),
                                  " mm is larger than its distance from the film, ",
                                  camera.film_distance_mm(), " mm"));
  if (auto fault = wire::film_fault(camera.film_diagonal_mm(), camera.film_gauge()))
    faults.push_back(*std::move(fault));
  if (!(camera.scene_distance() >= 0 && std::isfinite(camera.scene_distance())))
    faults.push_back(absl::StrCat("a scene at a distance of ", camera.scene_distance()));
  if (!(camera.units_per_mm() >= 0 && std::isfinite(camera.units_per_mm())))
    faults.push_back(absl::StrCat("a millimetre is not ", camera.units_per_mm(), " units of the scene"));
  const double nm = camera.wavelength_nm();
  if (nm != 0 && !(nm >= kLeastSensorNm && nm <= kMostSensorNm))
    faults.push_back(
        absl::StrCat("a wavelength of ", nm, " nm is not in ", kLeastSensorNm, " to ", kMostSensorNm, " nm"));
  if (faults.empty()) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("the pinhole: ", absl::StrJoin(faults, "; ")));
}

std::shared_ptr<const HoleTable> hole_table(const v1::PinholeCamera& camera, bool spectral) {
  auto table = std::make_shared<HoleTable>();
  const double units_per_mm = camera.units_per_mm() > 0 ? camera.units_per_mm() : 1e-3;
  const double radius = camera.hole_mm() / 2, distance = camera.film_distance_mm();
  const double inverse_scene = camera.scene_distance() > 0 ? units_per_mm / camera.scene_distance() : 0;
  const double inverse = 1 / distance + inverse_scene;
  table->radius = static_cast<float>(radius * units_per_mm);
  table->spread = static_cast<float>(radius * inverse);
  table->inward = static_cast<float>(radius * inverse_scene);
  const double squared = radius * radius, film_squared = distance * distance;
  table->weight = static_cast<float>(camera.brightness() == v1::LensCamera::IRRADIANCE
                                         ? std::numbers::pi * squared / film_squared
                                         : (squared + film_squared) / film_squared);
  if (camera.diffraction() == v1::PinholeCamera::STRAIGHT) return table;
  const auto fresnel_number = [&](double nm) { return squared * inverse / (nm * kMmInNm); };
  if (!spectral) {
    add_pattern(fresnel_number(camera.wavelength_nm() > 0 ? camera.wavelength_nm() : kMiddleOfLightNm),
                *table);
    return table;
  }
  table->wavelengths = patterns_for(fresnel_number(kMiddleOfLightNm));
  const double step = (kMostSensorNm - kLeastSensorNm) / (table->wavelengths - 1);
  table->first_nm = static_cast<float>(kLeastSensorNm);
  table->wavelengths_per_nm = static_cast<float>(1 / step);
  for (int i = 0; i < table->wavelengths; ++i) add_pattern(fresnel_number(kLeastSensorNm + i * step), *table);
  return table;
}

}  // namespace tessera::render
