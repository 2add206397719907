// Counts as colours.
#pragma once

#include <array>

#include "absl/status/statusor.h"
#include "image/image.h"

namespace tessera::client {

/// From black (1) by blue, red and yellow to white (1024 and more), evenly in the logarithm of the count.
/// Linear.
std::array<float, 3> heat_colour(double count);

/// The nodes and primitives that camera rays visit (--aov visits), together, as visits.R, .G and .B.
/// InvalidArgument where the image has no such channels.
absl::StatusOr<Image> heat_map(const Image& image);

}  // namespace tessera::client
