// All that is known of a round shape in closed form and in double precision, for questions about geometry
// (query/). Round shapes turn about the z axis of their object space; all functions are of that space.
#pragma once

#include <optional>
#include <vector>

#include "render/shape/shape_table.h"

namespace tessera::render {

/// A piece of the curve that turns about the z axis; x is the distance from it. A segment from (ax, az) to
/// (bx, bz), or an arc about (ax, az) of radius `radius` between two heights.
struct ProfilePiece {
  double ax, az, bx, bz;
  double radius = 0, z_low = 0, z_high = 0;
};

struct RoundForm {
  /// Whether the shape bounds a solid.
  bool (*is_solid)(const QuadricRecord& shape);
  /// Whether a point is in that solid; null for kinds that bound none.
  bool (*contains)(const QuadricRecord& shape, const double (&p)[3]);
  /// The greatest a . p over the points p of a shape that is whole: no part of a turn, or of a sphere.
  double (*support)(const QuadricRecord& shape, const double (&a)[3]);
  /// The curve that turns; whether it turns all the way is in the record.
  std::vector<ProfilePiece> (*profile)(const QuadricRecord& shape);
};

}  // namespace tessera::render
