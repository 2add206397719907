#include "photometry/units/light_unit.h"

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "absl/strings/str_cat.h"
#include "base/nearest_name.h"
#include "photometry/units/spelling.h"

namespace tessera::photometry {
namespace {

/// The meaning of a symbol: a factor, and the powers of lumen or watt, steradian and metre in it.
struct Symbol {
  std::string_view name;
  double factor;
  int lumen, watt, steradian, metre;
  bool takes_prefix = false;
};

constexpr double kFoot = 0.3048, kInch = 0.0254, kYard = 0.9144;
constexpr double kOverPi = 1 / std::numbers::pi;

constexpr Symbol kSymbols[] = {
    {"W", 1, 0, 1, 0, 0, true},
    {"lm", 1, 1, 0, 0, 0, true},
    {"cd", 1, 1, 0, -1, 0, true},
    {"lx", 1, 1, 0, 0, -2, true},
    {"nt", 1, 1, 0, -1, -2, true},
    {"sr", 1, 0, 0, 1, 0},
    {"m", 1, 0, 0, 0, 1},
    {"mm", 1e-3, 0, 0, 0, 1},
    {"cm", 1e-2, 0, 0, 0, 1},
    {"km", 1e3, 0, 0, 0, 1},
    {"ft", kFoot, 0, 0, 0, 1},
    {"in", kInch, 0, 0, 0, 1},
    {"fc", 1 / (kFoot * kFoot), 1, 0, 0, -2},
    {"ftc", 1 / (kFoot * kFoot), 1, 0, 0, -2},
    {"ph", 1e4, 1, 0, 0, -2},
    {"fL", kOverPi / (kFoot * kFoot), 1, 0, -1, -2},
    {"ftL", kOverPi / (kFoot * kFoot), 1, 0, -1, -2},
    {"sb", 1e4, 1, 0, -1, -2},
    {"asb", kOverPi, 1, 0, -1, -2},
    {"watt", 1, 0, 1, 0, 0},
    {"watts", 1, 0, 1, 0, 0},
    {"kilowatt", 1e3, 0, 1, 0, 0},
    {"kilowatts", 1e3, 0, 1, 0, 0},
    {"milliwatt", 1e-3, 0, 1, 0, 0},
    {"milliwatts", 1e-3, 0, 1, 0, 0},
    {"lumen", 1, 1, 0, 0, 0},
    {"lumens", 1, 1, 0, 0, 0},
    {"kilolumen", 1e3, 1, 0, 0, 0},
    {"kilolumens", 1e3, 1, 0, 0, 0},
    {"candela", 1, 1, 0, -1, 0},
    {"candelas", 1, 1, 0, -1, 0},
    {"millicandela", 1e-3, 1, 0, -1, 0},
    {"lux", 1, 1, 0, 0, -2},
    {"kilolux", 1e3, 1, 0, 0, -2},
    {"phot", 1e4, 1, 0, 0, -2},
    {"footcandle", 1 / (kFoot * kFoot), 1, 0, 0, -2},
    {"footcandles", 1 / (kFoot * kFoot), 1, 0, 0, -2},
    {"nit", 1, 1, 0, -1, -2, true},
    {"nits", 1, 1, 0, -1, -2},
    {"footlambert", kOverPi / (kFoot * kFoot), 1, 0, -1, -2},
    {"footlamberts", kOverPi / (kFoot * kFoot), 1, 0, -1, -2},
    {"stilb", 1e4, 1, 0, -1, -2},
    {"apostilb", kOverPi, 1, 0, -1, -2},
    {"steradian", 1, 0, 0, 1, 0},
    {"steradians", 1, 0, 0, 1, 0},
};

struct Prefix {
  std::string_view letter;
  double factor;
};
constexpr Prefix kPrefixes[] = {{"n", 1e-9}, {"u", 1e-6}, {"m", 1e-3}, {"k", 1e3}, {"M", 1e6}};

/// The symbol of a name, its factor with that of its prefix: by its letters, or else whatever their case.
std::optional<Symbol> find_symbol(std::string_view name) {
  for (const bool any_case : {false, true}) {
    const auto equal = [&](std::string_view a, std::string_view b) {
      return any_case ? lower(a) == lower(b) : a == b;
    };
    for (const Symbol& symbol : kSymbols) {
      if (equal(symbol.name, name)) return symbol;
      if (!symbol.takes_prefix) continue;
      for (const Prefix& prefix : kPrefixes) {
        // Letters that differ in case alone are other prefixes.
        if (!name.starts_with(prefix.letter) || !equal(symbol.name, name.substr(1))) continue;
        Symbol larger = symbol;
        larger.factor *= prefix.factor;
        return larger;
      }
    }
  }
  return std::nullopt;
}

struct WeightingName {
  std::string_view prefix;
  Weighting weighting;
};
constexpr WeightingName kWeightings[] = {{"photopic ", Weighting::kPhotopic},
                                         {"scotopic ", Weighting::kScotopic},
                                         {"melanopic ", Weighting::kMelanopic}};

constexpr std::string_view kBaseNames[2][4] = {{"W", "W/sr", "W/m2", "W/(m2 sr)"},
                                               {"lm", "cd", "lx", "cd/m2"}};

std::vector<std::string> names_of_light_units() {
  std::vector<std::string> names = {"W",     "W/sr", "W/m2", "W/(m2 sr)", "lm",  "cd",  "lx",
                                    "cd/m2", "nit",  "fc",   "klm",       "kcd", "mcd", "klx",
                                    "kW",    "mW",   "fL",   "lm/m2",     "asb"};
  for (const Symbol& symbol : kSymbols) {
    if (symbol.name.size() > 2) names.emplace_back(symbol.name);
  }
  return names;
}

absl::Status unknown(std::string_view text) {
  const std::string name(text);
  return absl::InvalidArgumentError(absl::StrCat(
      "no unit of light is called '", name, "'", base::did_you_mean(name, names_of_light_units()),
      "; lm, cd, lx, cd/m2 (nit), W, W/sr, W/m2 and W/(m2 sr) are"));
}

/// The quantity of powers of steradian and metre.
std::optional<Quantity> quantity_of(int steradian, int metre) {
  if (steradian == 0 && metre == 0) return Quantity::kFlux;
  if (steradian == -1 && metre == 0) return Quantity::kIntensity;
  if (steradian == 0 && metre == -2) return Quantity::kIrradiance;
  if (steradian == -1 && metre == -2) return Quantity::kRadiance;
  return std::nullopt;
}

struct LengthName {
  std::string_view name;
  double metres;
};
constexpr LengthName kLengths[] = {{"m", 1},
                                   {"mm", 1e-3},
                                   {"cm", 1e-2},
                                   {"km", 1e3},
                                   {"in", kInch},
                                   {"ft", kFoot},
                                   {"yd", kYard},
                                   {"metre", 1},
                                   {"metres", 1},
                                   {"meter", 1},
                                   {"meters", 1},
                                   {"millimetre", 1e-3},
                                   {"millimetres", 1e-3},
                                   {"millimeter", 1e-3},
                                   {"millimeters", 1e-3},
                                   {"centimetre", 1e-2},
                                   {"centimetres", 1e-2},
                                   {"centimeter", 1e-2},
                                   {"centimeters", 1e-2},
                                   {"kilometre", 1e3},
                                   {"kilometres", 1e3},
                                   {"kilometer", 1e3},
                                   {"kilometers", 1e3},
                                   {"inch", kInch},
                                   {"inches", kInch},
                                   {"foot", kFoot},
                                   {"feet", kFoot},
                                   {"yard", kYard},
                                   {"yards", kYard}};

}  // namespace

LightUnit base_unit(Quantity quantity, Weighting weighting) {
  const bool photometric = weighting != Weighting::kRadiometric;
  const std::string name(kBaseNames[photometric ? 1 : 0][static_cast<std::size_t>(quantity)]);
  const std::string prefix = weighting == Weighting::kScotopic    ? "scotopic "
                             : weighting == Weighting::kMelanopic ? "melanopic "
                                                                  : "";
  return {quantity, weighting, 1, prefix + name};
}

absl::StatusOr<LightUnit> parse_light_unit(std::string_view text) {
  std::string_view rest = text;
  LightUnit unit;
  std::optional<Weighting> weighting;
  for (const WeightingName& known : kWeightings) {
    if (lower(rest.substr(0, known.prefix.size())) != known.prefix) continue;
    weighting = known.weighting;
    rest.remove_prefix(known.prefix.size());
    break;
  }
  const auto factors = factors_of(rest);
  if (!factors || factors->empty()) return unknown(text);
  int lumen = 0, watt = 0, steradian = 0, metre = 0;
  for (const UnitFactor& one : *factors) {
    const auto symbol = find_symbol(one.symbol);
    if (!symbol) return unknown(text);
    lumen += one.power * symbol->lumen, watt += one.power * symbol->watt;
    steradian += one.power * symbol->steradian, metre += one.power * symbol->metre;
    unit.factor *= std::pow(symbol->factor, one.power);
  }
  const auto quantity = quantity_of(steradian, metre);
  if (!quantity || lumen + watt != 1 || lumen * watt != 0) return unknown(text);
  unit.quantity = *quantity;
  unit.weighting = lumen == 1 ? Weighting::kPhotopic : Weighting::kRadiometric;
  if (weighting == Weighting::kMelanopic) {
    // A melanopic lumen is that of as much daylight.
    if (lumen == 0) unit.factor /= kMelanopicWattsPerLumen;
    unit.weighting = *weighting;
  } else if (weighting) {
    if (lumen == 0) return unknown(text);
    unit.weighting = *weighting;
  }
  if (!std::isfinite(unit.factor) || !(unit.factor > 0)) return unknown(text);
  unit.name = std::string(text);
  return unit;
}

std::optional<double> conversion(const LightUnit& from, const LightUnit& to) {
  if (from.quantity != to.quantity) return std::nullopt;
  const double ratio = from.factor / to.factor;
  if (from.weighting == to.weighting) return ratio;
  if (from.weighting == Weighting::kRadiometric && to.weighting == Weighting::kPhotopic)
    return ratio * kLumensPerWatt;
  if (from.weighting == Weighting::kPhotopic && to.weighting == Weighting::kRadiometric)
    return ratio / kLumensPerWatt;
  return std::nullopt;
}

std::string name_of_quantity(Quantity quantity, Weighting weighting) {
  static constexpr std::string_view kRadiant[] = {"radiant flux", "radiant intensity", "irradiance",
                                                  "radiance"};
  static constexpr std::string_view kLuminous[] = {"luminous flux", "luminous intensity", "illuminance",
                                                   "luminance"};
  const auto index = static_cast<std::size_t>(quantity);
  if (weighting == Weighting::kRadiometric) return std::string(kRadiant[index]);
  const std::string name(kLuminous[index]);
  if (weighting == Weighting::kScotopic) return "scotopic " + name;
  if (weighting == Weighting::kMelanopic) return "melanopic equivalent daylight " + name;
  return name;
}

std::string units_of(Quantity quantity) {
  switch (quantity) {
    case Quantity::kFlux:
      return "lm or W";
    case Quantity::kIntensity:
      return "cd or W/sr";
    case Quantity::kIrradiance:
      return "lx or W/m2";
    case Quantity::kRadiance:
      break;
  }
  return "cd/m2 (nit) or W/(m2 sr)";
}

absl::StatusOr<double> parse_length_unit(std::string_view text) {
  const std::string_view name = without_blanks(text);
  for (const LengthName& known : kLengths) {
    if (known.name == name) return known.metres;
  }
  const std::string small = lower(name);
  for (const LengthName& known : kLengths) {
    if (known.name.size() > 2 && known.name == small) return known.metres;
  }
  if (const auto number = whole_number(name)) {
    if (*number > 0 && std::isfinite(*number)) return *number;
    return absl::InvalidArgumentError(
        absl::StrCat("a unit of length of ", std::string(name), " metres is not above 0"));
  }
  std::vector<std::string> names;
  for (const LengthName& known : kLengths) names.emplace_back(known.name);
  return absl::InvalidArgumentError(absl::StrCat("no unit of length is called '", std::string(text), "'",
                                                 base::did_you_mean(std::string(text), names),
                                                 "; m, mm, cm, km, in, ft, yd and numbers of metres are"));
}

std::string name_of_length(double metres) {
  for (const LengthName& known : kLengths) {
    if (known.name.size() <= 2 && std::abs(metres / known.metres - 1) < 1e-9) return std::string(known.name);
  }
  return absl::StrCat(metres, " m");
}

}  // namespace tessera::photometry
