// How different two pictures look.
#pragma once

#include "absl/status/statusor.h"
#include "image/image.h"

namespace tessera::client {

/// Mean LDR-FLIP, 0 (no difference can be seen) to 1, of two images as write_png shows them, at 67 pixels a
/// degree of sight (a 4K screen of 0.7 m seen from 0.7 m) [Andersson et al. 2020]. What is not finite is
/// black. InvalidArgument when sizes differ.
absl::StatusOr<double> flip_error(const Image& reference, const Image& test);

}  // namespace tessera::client
