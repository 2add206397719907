// Units of light: what each measures, and its factor to the base unit of that quantity.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace tessera::photometry {

/// Quantities by how they spread: over directions, over area, over both. Radiosity and exitance are
/// irradiances that leave.
enum class Quantity { kFlux, kIntensity, kIrradiance, kRadiance };

/// Weight of light before it is summed over wavelengths: by nothing (watts), by V(lambda), by
/// V'(lambda), or by the melanopic action spectrum.
enum class Weighting { kRadiometric, kPhotopic, kScotopic, kMelanopic };

/// Luminous efficacy of radiation at 540 THz, lm/W, which defines the lumen [BIPM 2019].
inline constexpr double kLumensPerWatt = 683;
/// The greatest efficacy in the dark, lm/W: what makes V' 683 lm/W at 540 THz, too [CIE 1951].
inline constexpr double kScotopicLumensPerWatt = 1700;
/// Melanopic efficacy of luminous radiation of D65, W/lm: 1 lx of melanopic equivalent daylight is so many
/// melanopic W/m^2 [CIE S 026:2018].
inline constexpr double kMelanopicWattsPerLumen = 1.3262e-3;

/// Base units: W or lm, over sr, m^2 or both.
struct LightUnit {
  Quantity quantity = Quantity::kFlux;
  Weighting weighting = Weighting::kPhotopic;
  double factor = 1;  // number of base units in it
  std::string name;   // as it is written in tables: "W/(m2 sr)"

  bool photometric() const { return weighting != Weighting::kRadiometric; }
  bool operator==(const LightUnit&) const = default;
};

/// Reads a product of W, lm, cd, lx, nt (nit), sr, m, cm, mm, km, ft, in and their powers: "W/m^2", "W/m²",
/// "W·sr⁻¹", "W m-2 sr-1", "lm/ft2"; fc, fL, sb, ph, asb; names in full ("lux", "candela"); with prefixes of
/// the SI from n to M before W, lm, cd, lx and nt. "scotopic ", "melanopic " and "photopic " before it change
/// its weighting: "melanopic lx" is melanopic equivalent daylight illuminance (D65), "melanopic W/m2"
/// irradiance by the action spectrum. InvalidArgument for all others, with the nearest name.
absl::StatusOr<LightUnit> parse_light_unit(std::string_view text);

/// The base unit of a quantity: lm, cd, lx, cd/m2, or W, W/sr, W/m2, W/(m2 sr).
LightUnit base_unit(Quantity quantity, Weighting weighting);

/// How much one of `from` is in `to`. Between watts and lumens 683 lm/W holds: it is light of 555 nm, or of
/// jobs of RGB, whose watts are lumens over 683. Nothing where quantities differ, or other weightings.
std::optional<double> conversion(const LightUnit& from, const LightUnit& to);

/// "luminous flux", "illuminance", "radiance", "melanopic irradiance", ...
std::string name_of_quantity(Quantity quantity, Weighting weighting);

/// Units that measure a quantity, for messages: "lm or W".
std::string units_of(Quantity quantity);

/// The length of a unit in metres: "m", "mm", "cm", "km", "in", "ft", "yd", names in full, or a number of
/// metres. InvalidArgument for all others, with the nearest name, and for numbers that are not above 0.
absl::StatusOr<double> parse_length_unit(std::string_view text);

/// The name of a unit of so many metres ("mm"); else the number with "m".
std::string name_of_length(double metres);

}  // namespace tessera::photometry
