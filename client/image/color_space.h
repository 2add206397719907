// The space that red, green and blue of an image are in.
#pragma once

#include <optional>

#include "image/image.h"
#include "spectra/color/rgb_space.h"

namespace tessera::client {

inline constexpr const char kChromaticities[] = "chromaticities";
/// Metadata of an image whose channels are a sensor's own, in no space: the sensor's name.
inline constexpr const char kRawChannels[] = "tessera.raw_channels";

/// The space of an image's metadata; Rec.709 where they tell of none, or of primaries that span none.
spectra::RgbSpace space_of(const Image& image);
void set_space(const spectra::RgbSpace& space, Image& image);

/// From red, green and blue of the image to Rec.709, white on white; nothing where they are in it.
std::optional<spectra::Matrix3> rec709_from(const Image& image);

/// Converts red, green and blue, and those of all layers of light, white on white.
void convert_space(const spectra::RgbSpace& space, Image& image);

}  // namespace tessera::client
