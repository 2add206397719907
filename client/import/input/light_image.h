// The images on lights, for what an importer must know of them: size and brightness.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "absl/status/statusor.h"
#include "images/image_blob.h"

namespace tessera::client {

/// Decoded pixels: linear RGB, rows from the top. Files of 8 bits a channel are taken as sRGB; a grey image
/// has three equal components.
struct LightImage {
  int width = 0, height = 0;
  std::vector<float> rgb;

  /// Luminance of linear Rec.709, at column x and row y.
  double luminance(int x, int y) const;
  double mean_of_channels(int x, int y) const;
};

/// InvalidArgument for what is no image, or for values that are not finite; NotFound.
absl::StatusOr<LightImage> read_light_image(const std::filesystem::path& path);

/// Reads no more than the header. InvalidArgument with the path for what is not an image; NotFound.
absl::StatusOr<images::ImageSize> read_image_size(const std::filesystem::path& path);

}  // namespace tessera::client
