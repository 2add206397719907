// Bands of spectral radiance in pictures.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace tessera::spectra {

inline constexpr int kMostBands = 512;

/// `count` bands of one width, side by side; 0: none.
struct Bands {
  int count = 0;
  double from_nm = 380, to_nm = 780;

  double width() const { return (to_nm - from_nm) / count; }
  double begin(int band) const { return from_nm + width() * band; }
  double centre(int band) const { return from_nm + width() * (band + 0.5); }
  bool operator==(const Bands&) const = default;
};

/// "rgb": none; "spectral:N": N bands from 380 to 780 nm; "spectral:N:FROM-TO". InvalidArgument for any
/// other.
absl::StatusOr<Bands> parse_film(const std::string& text);

/// The channel's name in spectral OpenEXR files [Fichet, Pacanowski & Wilkie 2021]: "S0.550,000000nm".
std::string band_channel(double centre_nm);
/// The centre of the band of that name, in nanometres; nothing for other names.
std::optional<double> centre_of_channel(std::string_view name);

}  // namespace tessera::spectra
