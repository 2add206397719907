// Synthetic apertures: which cameras of a grid make a picture, and with what weights.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "light_field/manifest.h"

namespace tessera::light_field {

/// An opening in the plane of a grid's cameras.
struct Aperture {
  double x = 0, y = 0;       // its middle, world units from that of the grid
  double radius = 0;         // 0: a pinhole
  std::uint32_t blades = 0;  // corners of a regular polygon on the circle, 3 to 64; 0: round
  double blade_degrees = 0;  // direction of the first corner, from x towards y
};

/// Half of the shorter side of the cameras' rectangle: the largest aperture that lies within it.
double largest_radius(const CameraGrid& grid);

/// Views and their weights, which add up to 1: radiance over the aperture is interpolated linearly between
/// cameras, so that a pinhole is that of quadrilinear interpolation. InvalidArgument where the aperture's
/// middle lies beside the cameras; what of it lies there is left out.
absl::StatusOr<std::vector<std::pair<std::uint32_t, float>>> camera_weights(const CameraGrid& grid,
                                                                            const Aperture& aperture);

}  // namespace tessera::light_field
