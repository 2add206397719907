// Depth by what is in focus, and pictures in which all is.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "light_field/refocus.h"

namespace tessera::light_field {

struct FocalStackOptions {
  double near = 0, far = 0;  // distances from the cameras' plane of what is looked for
  std::uint32_t planes = 32;
  std::uint32_t radius = 2;  // pixels around each whose agreement counts, too
  int threads = 1;
};

struct FocalStack {
  Picture sharp;              // each pixel at the plane where the views agree best
  std::vector<float> depths;  // the distance of that plane from the cameras' plane; 0: missing
};

/// Planes of focus at distances whose inverses are equally far apart are held against all views within the
/// aperture: the one at which their colours differ least is the pixel's [Vaish et al. 2006]. Between planes,
/// a parabola through the least three finds the depth. The depth of the set is not looked at. Errors are
/// those of refocus().
absl::StatusOr<FocalStack> focal_stack(LightField& field, const Aperture& aperture,
                                       const FocalStackOptions& options);

}  // namespace tessera::light_field
