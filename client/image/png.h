// Images for screens.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "image/exr/rows.h"
#include "image/image.h"
#include "image/view/display_view.h"

namespace tessera::client {

/// Writes R, G and B, from the space that they are in (color_space.h), as an 8-bit sRGB file of the data
/// window: values are clamped to [0, 1] and go through the sRGB transfer function (IEC 61966-2-1), unless
/// `view` says otherwise; what is no number is black. Dithered values are rounded up where a pixel's
/// threshold, of a low-discrepancy sequence [Roberts2018], is below the rest, so that means of areas keep
/// what 8 bits would lose. The file is replaced as a whole (atomic_file.h).
absl::Status write_png(const Image& image, const std::string& path, const ViewOptions& view = {});

/// The same of an image whose planes have names, but no values: those are `rows`, of which one is in memory.
absl::Status write_png(const Image& image, Rows& rows, const std::string& path, const ViewOptions& view = {});

/// The 8-bit sRGB code of a linear value, rounded to nearest.
unsigned char srgb_byte(float linear);

}  // namespace tessera::client
