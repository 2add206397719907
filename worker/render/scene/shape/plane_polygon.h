// A polygon in a plane while a scene is built.
#pragma once

#include <ImathVec.h>

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "render/scene/placement/transform.h"

namespace tessera::render {

/// A polygon in a space of its own: in z = 0, its box about the origin, of half-size 1 along the longer side.
struct PlanePolygon {
  Transform object_from_unit;
  std::vector<Imath::V2d> corners;
  float uv_map[6] = {};  // maps its x and y to the parameters of Polygon in shape.proto
};

/// From x y z of each corner. InvalidArgument where they are too few or too many, not finite, not in one
/// plane, or where two that follow one another are the same.
absl::StatusOr<PlanePolygon> plane_polygon(const std::vector<Imath::V3d>& corners);

/// Triangles that are the polygon, three indices of corners each, wound like it. InvalidArgument where edges
/// cross.
absl::StatusOr<std::vector<std::uint32_t>> triangulate(const std::vector<Imath::V2d>& corners);

}  // namespace tessera::render
