#include "render/scene/light/light_amount.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "spectra/observer/action_spectrum.h"

namespace tessera::render {
namespace {

using photometry::Quantity;

absl::StatusOr<Amount> read_fitting(const v1::LightAmount& amount, const char* what,
                                    std::initializer_list<Quantity> fitting) {
  if (!(amount.value() >= 0) || !std::isfinite(amount.value()))
    return absl::InvalidArgumentError("amount: its value is negative or not finite");
  const auto unit = photometry::parse_light_unit(amount.unit());
  if (!unit.ok()) return absl::InvalidArgumentError(absl::StrCat("amount: ", unit.status().message()));
  std::string names;
  for (const Quantity quantity : fitting)
    absl::StrAppend(&names, names.empty() ? "" : ", ", photometry::units_of(quantity));
  if (unit->weighting != photometry::Weighting::kPhotopic &&
      unit->weighting != photometry::Weighting::kRadiometric)
    return absl::InvalidArgumentError(
        absl::StrCat("amount: ", amount.unit(), " is a measure of effects; ", names, " are for lights"));
  if (std::ranges::find(fitting, unit->quantity) == fitting.end())
    return absl::InvalidArgumentError(
        absl::StrCat("amount: ", amount.unit(), " is a unit of ",
                     photometry::name_of_quantity(unit->quantity, unit->weighting), ", which ", what,
                     " does not have; ", names, " was expected"));
  return Amount{amount.value() * unit->factor, unit->quantity, unit->photometric()};
}

/// The integral over all directions of a falloff that is linear in the angle from 1 at `inner` to 0 at
/// `outer`: 2 pi times that of (outer - a) / (outer - inner) sin(a).
double linear_falloff(double inner, double outer) {
  const double width = outer - inner;
  return 2 * std::numbers::pi * (std::cos(inner) - (std::sin(outer) - std::sin(inner)) / width);
}

double solid_angle_of_spot(const LightRecord& light) {
  const double inner = light.cos_inner, outer = light.cos_outer;
  const double whole = 2 * std::numbers::pi * (1 - inner);
  if (!(inner > outer)) return whole;
  if (light.profile == kLinearAngle)
    return whole +
           linear_falloff(std::acos(std::clamp(inner, -1.0, 1.0)), std::acos(std::clamp(outer, -1.0, 1.0)));
  // The mean of a smoothstep over its range is one half.
  return whole + std::numbers::pi * (inner - outer);
}

double solid_angle_of_projection(const LightRecord& light) {
  const double x = light.tan_x, y = light.tan_y;
  if (light.profile == kEvenScreen) return 4 * x * y;
  return 4 * std::asin(std::clamp(x * y / std::sqrt((1 + x * x) * (1 + y * y)), -1.0, 1.0));
}

}  // namespace

absl::StatusOr<SceneScale> SceneScale::of(const v1::SceneUnits& units) {
  if (!(units.metres() >= 0) || !std::isfinite(units.metres()))
    return absl::InvalidArgumentError("units: metres is negative or not finite");
  if (!(units.cd_per_m2() >= 0) || !std::isfinite(units.cd_per_m2()))
    return absl::InvalidArgumentError("units: cd_per_m2 is negative or not finite");
  SceneScale scale;
  scale.says_metres = units.metres() > 0;
  if (scale.says_metres) scale.metres = units.metres();
  if (units.cd_per_m2() > 0) scale.cd_per_m2 = units.cd_per_m2();
  return scale;
}

absl::StatusOr<Amount> read_amount(const v1::LightAmount& amount, const v1::Light& light) {
  switch (light.kind_case()) {
    case v1::Light::kPoint:
      return read_fitting(amount, "a point light", {Quantity::kFlux, Quantity::kIntensity});
    case v1::Light::kSpot:
      return read_fitting(amount, "a spot light", {Quantity::kFlux, Quantity::kIntensity});
    case v1::Light::kProjection:
      return read_fitting(amount, "a projection light", {Quantity::kFlux, Quantity::kIntensity});
    case v1::Light::kGoniometric:
      return read_fitting(amount, "a goniometric light", {Quantity::kFlux, Quantity::kIntensity});
    case v1::Light::kDistant:
      return read_fitting(amount, "parallel light", {Quantity::kIrradiance});
    case v1::Light::kInfinite:
      if (light.infinite().has_image())
        return read_fitting(amount, "light of an image from all around", {Quantity::kRadiance});
      return read_fitting(amount, "light from all around", {Quantity::kRadiance, Quantity::kIrradiance});
    default:
      return absl::InvalidArgumentError("amount: a light of this kind is as bright as its own fields say");
  }
}

absl::StatusOr<Amount> read_amount(const v1::LightAmount& amount, const v1::AreaLight&) {
  return read_fitting(amount, "an area light", {Quantity::kFlux, Quantity::kIntensity, Quantity::kRadiance});
}

double light_of_record(const Amount& amount, const SpectralEmission& emission, const SceneScale& scale,
                       const SpectralBuilder* spectral) {
  if (amount.photometric) {
    return scale.cd_per_m2 *
           (spectral == nullptr ? luminance_of(emission.color) : spectral->luminance_of(emission));
  }
  const double watts_per_luminance = scale.cd_per_m2 / photometry::kLumensPerWatt;
  if (spectral == nullptr) return watts_per_luminance * luminance_of(emission.color);
  // A spectrum that is 1 everywhere has luminance 1: 683 lm/W times the integral of V(lambda) of its watts a
  // nanometre.
  constexpr double kFirst = 360, kLast = 830;
  return watts_per_luminance * spectral->mean_of(emission) * (kLast - kFirst) /
         spectra::photopic().integral(kFirst, kLast);
}

double filled_solid_angle(const LightRecord& light) {
  switch (light.kind) {
    case LightKind::kSpot:
    case LightKind::kSoftSpot:
      return solid_angle_of_spot(light);
    case LightKind::kProjection:
      return solid_angle_of_projection(light);
    default:
      return 4 * std::numbers::pi;
  }
}

double luminance_of(const spectra::Rgb& color) {
  return 0.212671 * color.r + 0.715160 * color.g + 0.072169 * color.b;
}

}  // namespace tessera::render
