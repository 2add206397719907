#include "spectra/named_spectra.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "spectra/light/daylight.h"
#include "spectra/light/illuminants.h"
#include "spectra/matter/glasses.h"
#include "spectra/matter/metals.h"
#include "spectra/rgb/pbrt_luminance.h"

namespace tessera::spectra {
namespace {

bool consume_prefix(std::string_view& text, std::string_view prefix) {
  if (!text.starts_with(prefix)) return false;
  text.remove_prefix(prefix.size());
  return true;
}

bool consume_suffix(std::string_view& text, std::string_view suffix) {
  if (!text.ends_with(suffix)) return false;
  text.remove_suffix(suffix.size());
  return true;
}

/// The metals that pbrt-v4 has; Mitsuba means other measurements by the names of others.
constexpr std::string_view kMetals[] = {"Ag", "Al", "Au", "Cu", "CuZn", "MgO", "TiO2"};

std::optional<Metal> find_pbrt_metal(std::string_view name) {
  return std::ranges::find(kMetals, name) == std::end(kMetals) ? std::nullopt : find_metal(name);
}

std::optional<Curve> unit_luminance(std::optional<Curve> curve) {
  if (!curve) return curve;
  const float scale = static_cast<float>(1 / pbrt_luminance(*curve));
  for (float& value : curve->values) value *= scale;
  return curve;
}

}  // namespace

std::optional<Curve> find_named_spectrum(std::string_view name) {
  if (consume_prefix(name, "metal-")) {
    const bool wants_eta = consume_suffix(name, "-eta");
    if (!wants_eta && !consume_suffix(name, "-k")) return std::nullopt;
    std::optional<Metal> metal = find_pbrt_metal(name);
    if (!metal) return std::nullopt;
    return std::move(wants_eta ? metal->eta : metal->k);
  }
  if (consume_prefix(name, "glass-")) return find_glass(name);
  if (consume_prefix(name, "stdillum-")) {
    if (name == "acesD60") return std::nullopt;
    return unit_luminance(name == "D50" ? pbrt_d50() : find_illuminant(name));
  }
  if (name == "illum-acesD60") return unit_luminance(find_illuminant("acesD60"));
  return std::nullopt;
}

std::vector<std::string> names_of_spectra() {
  std::vector<std::string> names;
  const auto add = [&names](std::string_view start, std::string_view name, std::string_view end = "") {
    names.push_back(std::string(start).append(name).append(end));
  };
  for (const std::string_view metal : kMetals) add("metal-", metal, "-eta"), add("metal-", metal, "-k");
  for (const std::string_view glass : kGlassNames) add("glass-", glass);
  for (const std::string_view illuminant : kIlluminantNames) {
    if (illuminant == "acesD60")
      add("illum-", illuminant);
    else
      add("stdillum-", illuminant);
  }
  return names;
}

}  // namespace tessera::spectra
