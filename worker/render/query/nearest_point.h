// The point of one surface that is closest to a given one.
#pragma once

#include <optional>
#include <span>

#include "render/query/solid.h"

namespace tessera::render {

/// The closest point of a triangle, and its weights of the second and third corner [Ericson2005, sec. 5.1.5].
struct TrianglePoint {
  V3d p;
  double b1 = 0, b2 = 0;
};
TrianglePoint nearest_on_triangle(const V3d& p, const V3d& a, const V3d& b, const V3d& c);

/// Nearest point of a plane polygon, which need not be convex: inside is where a line crosses its edges an
/// odd number of times.
V3d nearest_on_polygon(const V3d& p, std::span<const V3d> corners);

/// Nearest point of a sphere of radius `radius` about the origin of a space that `place` maps to that of `p`:
/// of an ellipsoid, in any position. Its Lagrange multiplier is the one root of a falling function, which is
/// halved to the last bit [Eberly2013].
V3d nearest_on_ellipsoid(const V3d& p, const ExactAffine& place, double radius);

/// Nearest point of a surface that turns about its axis, in closed form; `place` may stretch it along the
/// axis, but where it is round along that (spheres, tori). What `place` is off from such a map, up to 2^-18
/// of its scale, the answer is off. nullopt for other maps, and for kinds that are no such surface.
std::optional<V3d> nearest_on_round(const V3d& p, const ExactAffine& place, const ShapeTable& table,
                                    const ShapeRecord& shape, const QueryKernel& kernel);

/// The least that a map makes of a length of 1.
double least_scale(const ExactAffine& map);

}  // namespace tessera::render
