// OpenEXR files.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "image/image.h"

namespace tessera::client {

enum class PixelType {
  kFloat,  // 32 bits
  kHalf    // 16 bits for all but `samples` and `depth.*`; finite values beyond +-65504 are stored as +-65504
};

enum class ExrParts {
  kOne,
  kMany  // one for the channels without a layer's name, and one for each layer: "diffuse" has diffuse.R ...
};

/// Writes a scanline file with ZIP compression. The image's windows become dataWindow and displayWindow. The
/// file is replaced as a whole (atomic_file.h). InvalidArgument when planes do not fit the windows; Internal,
/// with the file's name, when the disk does not take it.
absl::Status write_exr(const Image& image, const std::string& path, PixelType type = PixelType::kFloat,
                       ExrParts parts = ExrParts::kOne);

/// Reads the first part of any flat file: half, float or 32-bit integer, scanlines or tiles (the
/// full-resolution level), RGB, luminance or luminance/chroma. Attributes of the types string, int and float
/// become metadata. NotFound when there is no such file; InvalidArgument, with the file's name, for a file
/// that is broken, deep, or larger than `max_pixels`. Never throws.
absl::StatusOr<Image> read_exr(const std::string& path, std::size_t max_pixels = std::size_t{1} << 28);

}  // namespace tessera::client
