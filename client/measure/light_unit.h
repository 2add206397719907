// Units of the figures of meters.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "measure/reading_channels.h"

namespace tessera::client {

enum class LightQuantity : std::uint8_t {
  kRadiance,
  kIrradiance,
  kExitance,
  kIntensity,
  kFlux,
  kDaylightFactor
};

/// A unit of a quantity, as figures are told in it.
struct FigureUnit {
  std::string name;      // "lx"
  std::string quantity;  // "illuminance"
  ReadingChannel channel = ReadingChannel::kLuminance;
  double factor = 1;  // of the number in this unit over the channel's
};

/// `text`: a unit of the quantity, as people write it; empty: the photometric one. `cd_per_m2`: luminance of
/// a radiance of 1. Light of wavelengths (`is_spectral`) is weighed by them. InvalidArgument where it is no
/// unit, or one of another quantity, or of light that RGB does not tell.
absl::StatusOr<FigureUnit> unit_of(const std::string& text, LightQuantity quantity, double cd_per_m2,
                                   bool is_spectral);

}  // namespace tessera::client
