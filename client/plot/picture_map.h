// The luminance of pictures, in cd/m^2, to be shown as colours.
#pragma once

#include <optional>

#include "absl/status/statusor.h"
#include "image/image.h"
#include "plot/false_color.h"

namespace tessera::client {

/// Luminance of radiance 1 W/(m^2 sr): of light at 555 nm [BIPM2019], and of all light of pictures that do
/// not say otherwise.
inline constexpr double kLumensPerWatt = 683;

/// The luminance that pixels of 1 stand for: `asked`, or as the file says (OpenEXR's whiteLuminance), or
/// kLumensPerWatt.
double white_luminance(const Image& image, const std::optional<double>& asked);

/// Luminances of all pixels, by the space that red, green and blue are in; those of an image without them are
/// its Y or first channel. FailedPrecondition where the channels are a sensor's own, which tell no luminance.
absl::StatusOr<ValueGrid> luminance_grid(const Image& image, double white_luminance);

/// How pictures are shown: their brightest thousandth of pixels may be beyond the scale, and isolines that
/// noise makes are left out.
FalseColorOptions picture_look();

}  // namespace tessera::client
