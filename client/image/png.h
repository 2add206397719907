// Tone-mapped previews.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "image/exr/rows.h"
#include "image/image.h"

namespace tessera::client {

/// Writes R, G and B, from the space that they are in (color_space.h), as an 8-bit sRGB file of the data
/// window: values are clamped to [0, 1] and go through the sRGB transfer function (IEC 61966-2-1); what is
/// not finite is black. The file is replaced as a whole (atomic_file.h).
absl::Status write_png(const Image& image, const std::string& path);

/// The same of an image whose planes have names, but no values: those are `rows`, of which one is in memory.
absl::Status write_png(const Image& image, Rows& rows, const std::string& path);

/// The 8-bit sRGB code of a linear value, rounded to nearest.
unsigned char srgb_byte(float linear);

}  // namespace tessera::client
