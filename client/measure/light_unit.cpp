#include "measure/light_unit.h"

#include "absl/strings/str_cat.h"
#include "photometry/units/light_unit.h"

namespace tessera::client {

namespace {

/// Luminance of 1 W/(m^2 sr nm) at all wavelengths: 683 lm/W times the integral of V(lambda) in nm.
constexpr double kSpectralLuminance = 683 * 106.856895;

using photometry::Quantity;
using photometry::Weighting;

Quantity spread_of(LightQuantity quantity) {
  switch (quantity) {
    case LightQuantity::kRadiance:
      return Quantity::kRadiance;
    case LightQuantity::kIntensity:
      return Quantity::kIntensity;
    case LightQuantity::kFlux:
      return Quantity::kFlux;
    default:
      return Quantity::kIrradiance;
  }
}

std::string quantity_name(LightQuantity quantity, Weighting weighting) {
  if (quantity == LightQuantity::kExitance)
    return weighting == Weighting::kRadiometric ? "radiant exitance" : "luminous exitance";
  return photometry::name_of_quantity(spread_of(quantity), weighting);
}

}  // namespace

absl::StatusOr<FigureUnit> unit_of(const std::string& text, LightQuantity quantity, double cd_per_m2,
                                   bool is_spectral) {
  if (quantity == LightQuantity::kDaylightFactor) {
    if (text.empty() || text == "%") return FigureUnit{"%", "daylight factor"};
    return absl::InvalidArgumentError(absl::StrCat("a daylight factor is in %, not in '", text, "'"));
  }
  const Quantity spread = spread_of(quantity);
  photometry::LightUnit unit = photometry::base_unit(spread, Weighting::kPhotopic);
  if (quantity == LightQuantity::kExitance) unit.name = "lm/m2";
  if (!text.empty()) {
    const auto parsed = photometry::parse_light_unit(text);
    if (!parsed.ok()) return parsed.status();
    if (parsed->quantity != spread)
      return absl::InvalidArgumentError(absl::StrCat("'", text, "' is no unit of ",
                                                     quantity_name(quantity, Weighting::kPhotopic), ": ",
                                                     photometry::units_of(spread), " are"));
    unit = *parsed;
  }
  FigureUnit figure{unit.name, quantity_name(quantity, unit.weighting)};
  // Where the luminance of a radiance of 1 is that of a spectrum of 1 W/(m^2 sr nm), bands are in that unit.
  const double spectral = cd_per_m2 / kSpectralLuminance;
  switch (unit.weighting) {
    case Weighting::kPhotopic:
      figure.factor = cd_per_m2 / unit.factor;
      return figure;
    case Weighting::kRadiometric:
      // In RGB, watts are lumens over 683: of light that the eye sees best.
      figure.factor = (is_spectral ? spectral : cd_per_m2 / photometry::kLumensPerWatt) / unit.factor;
      if (is_spectral) figure.channel = ReadingChannel::kRadiant;
      return figure;
    case Weighting::kScotopic:
      figure.channel = ReadingChannel::kScotopic;
      break;
    case Weighting::kMelanopic:
      figure.channel = ReadingChannel::kMelanopic;
      break;
  }
  if (!is_spectral)
    return absl::InvalidArgumentError(
        absl::StrCat("'", text, "' weighs light by its wavelength: that takes --color spectral"));
  figure.factor = spectral / unit.factor;
  return figure;
}

}  // namespace tessera::client
