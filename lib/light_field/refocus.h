// Pictures through synthetic apertures [Isaksen et al. 2000; Ng 2005].
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "light_field/aperture.h"
#include "light_field/interpolate.h"

namespace tessera::light_field {

/// A plane of focus in the space of the grid: the points whose z is distance + slope_x x + slope_y y.
struct FocusPlane {
  double distance = 1;  // from the plane of the cameras, world units
  double slope_x = 0, slope_y = 0;
};

/// The camera of a refocused picture: in the grid's plane, at (x, y) from its middle, with the window that
/// the grid's cameras have at their focus.
Pinhole camera_of_grid(const Manifest& manifest, const CameraGrid& grid, double x, double y);

/// The picture that a lens of this aperture in the grid's plane makes: rays through it that meet at the plane
/// of focus are a pixel. Pixels are those of camera_of_grid() at the aperture's middle, of the views' size;
/// one that no camera sees is missing. Views are read one by one, and freed. InvalidArgument where the set
/// has no grid, as of camera_weights(), or where the plane of focus does not lie before the cameras.
absl::StatusOr<Picture> refocus(LightField& field, const Aperture& aperture, const FocusPlane& focus,
                                int threads);

/// The grid of a two-plane set. InvalidArgument where it has none, or several.
absl::StatusOr<CameraGrid> only_grid(const Manifest& manifest);

}  // namespace tessera::light_field
