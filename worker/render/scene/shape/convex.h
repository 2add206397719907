// Convex polyhedra while a scene is built: from planes to faces, and from vertices to planes.
#pragma once

#include <ImathVec.h>

#include <vector>

#include "absl/status/statusor.h"

namespace tessera::render {

/// All points p with p . normal <= offset; the normal is of unit length.
struct Plane {
  Imath::V3d normal;
  double offset = 0;
};

struct ConvexFace {
  Plane plane;
  std::vector<Imath::V3d> corners;  // counterclockwise, seen from outside
};

/// The faces of all that is behind the planes, which need not be of unit length; planes that bound nothing
/// are left out. Corners that faces share are equal. InvalidArgument where that is nothing, or has no end.
absl::StatusOr<std::vector<ConvexFace>> faces_behind(const std::vector<Plane>& planes);

/// The planes about the hull of points, for faces_behind(). InvalidArgument where they lie in one plane.
absl::StatusOr<std::vector<Plane>> hull_of(const std::vector<Imath::V3d>& points);

}  // namespace tessera::render
