// Layers of an image, to be looked at.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "image/image.h"

namespace tessera::client {

/// The pixels of these layers side by side, from left to right, as R, G and B. "rgba" is the picture itself,
/// "visits" the heat map of what camera rays visit (heat_map.h).
/// InvalidArgument, naming it, where the image has no such layer.
absl::StatusOr<Image> layer_strip(const Image& image, const std::vector<std::string>& layers);

}  // namespace tessera::client
