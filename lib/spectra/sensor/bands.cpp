#include "spectra/sensor/bands.h"

#include <algorithm>
#include <charconv>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "base/nearest_name.h"
#include "spectra/sensor/sensor_name.h"

namespace tessera::spectra {
namespace {

constexpr const char* kSpectral = "spectral";
constexpr std::string_view kRadiance = "S0.", kUnit = "nm";

}  // namespace

absl::StatusOr<Bands> parse_film(const std::string& text) {
  if (text == "rgb") return Bands{};
  const std::vector<std::string> parts = absl::StrSplit(text, ':');
  const bool spectral = parts[0] == kSpectral;
  if (!spectral || parts.size() < 2 || parts.size() > 3) {
    return absl::InvalidArgumentError(
        absl::StrCat("expected rgb, spectral:N or spectral:N:FROM-TO, not '", text, "'",
                     spectral ? "" : base::did_you_mean(parts[0], {"rgb", kSpectral})));
  }
  Bands bands;
  const char* const last = parts[1].data() + parts[1].size();
  const auto [end, error] = std::from_chars(parts[1].data(), last, bands.count);
  if (error != std::errc{} || end != last || bands.count < 1 || bands.count > kMostBands) {
    return absl::InvalidArgumentError(
        absl::StrCat("a spectral film has 1 to ", kMostBands, " bands, not '", parts[1], "'"));
  }
  if (parts.size() == 2) return bands;
  const absl::StatusOr<NmRange> asked = parse_nm_range(parts[2], "the spectral film");
  if (!asked.ok()) return asked.status();
  bands.from_nm = asked->from, bands.to_nm = asked->to;
  return bands;
}

std::string band_channel(double centre_nm) {
  std::string number = absl::StrFormat("%.6f", centre_nm);
  std::ranges::replace(number, '.', ',');
  return std::string(kRadiance) + number + std::string(kUnit);
}

std::optional<double> centre_of_channel(std::string_view name) {
  if (!name.starts_with(kRadiance) || !name.ends_with(kUnit)) return std::nullopt;
  std::string number(name.substr(kRadiance.size(), name.size() - kRadiance.size() - kUnit.size()));
  std::ranges::replace(number, ',', '.');
  double nm = 0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), nm);
  if (error != std::errc{} || end != number.data() + number.size() || !(nm > 0)) return std::nullopt;
  return nm;
}

}  // namespace tessera::spectra
