// The bytes of a texture: an image file as it is. What is plain is decoded by this program's own readers, all
// else by OpenImageIO, which lives in a module of its own that is opened at the first need
// (docs/decisions/0014-scene-loading.md).
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace tessera::images {

struct ImageSize {
  std::int32_t width = 0, height = 0;  // pixels
};

/// Decoded pixels, rows from the top, always four channels (R, G, B, A) interleaved: grey is spread over R, G
/// and B, blue is 0 beside red and green alone, alpha is 1 (255) where the file has none, and colours are
/// never multiplied by it. Values are as the file encodes them.
struct ImagePixels {
  ImageSize size;
  bool floating_point = false;       // whether the file held floats, or integers of whatever depth
  std::vector<std::uint32_t> bytes;  // pixels of files of 8 bits a channel: R | G << 8 | B << 16 | A << 24
  std::vector<float> floats;  // pixels of all others; integers are divided by the largest of their type
};

/// Decodes a PNG, JPEG, WebP, TGA, BMP, EXR, HDR, PFM, PNM or TIFF file. The format is told by the bytes, for
/// TGA (which has no mark) by the extension of `name`, which otherwise serves only for messages.
/// InvalidArgument names the file and what is wrong with it; ResourceExhausted for more than `max_pixels`.
/// Thread-safe.
absl::StatusOr<ImagePixels> decode_image(std::string_view blob, const std::string& name,
                                         std::uint64_t max_pixels = std::uint64_t{1} << 28);

/// Size of the same files, from the header alone; the same errors, as far as it tells them.
absl::StatusOr<ImageSize> image_size(std::string_view blob, const std::string& name,
                                     std::uint64_t max_pixels = std::numeric_limits<std::uint64_t>::max());

}  // namespace tessera::images
