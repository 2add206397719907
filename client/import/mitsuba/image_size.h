// The size of an image file.
#pragma once

#include <filesystem>

#include "absl/status/statusor.h"

namespace tessera::client::mitsuba {

struct ImageSize {
  int width = 0;  // pixels
  int height = 0;
};

/// Reads no more than the header. InvalidArgument with the path for what is not an image.
absl::StatusOr<ImageSize> read_image_size(const std::filesystem::path& path);

}  // namespace tessera::client::mitsuba
