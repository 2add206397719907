// Generalised winding numbers of meshes [Jacobson2013].
#pragma once

#include <span>
#include <vector>

#include "render/accel/bvh/bvh.h"
#include "render/query/maps.h"
#include "render/shape/shape_table.h"

namespace tessera::render {

/// How often a mesh, closed or not, goes around a point: the solid angle that it covers there over 4 pi,
/// counted positive where its normals point away. Whole numbers for closed meshes, about 1/2 in a large hole.
///
/// Triangles that are near are summed exactly [VanOosterom1983]; groups that are farther away than
/// kFar times their size stand for their triangles by two terms of an expansion [Barill2018].
class WindingTree {
 public:
  WindingTree(const ShapeTable& table, const ShapeRecord& mesh, int threads);

  /// Winding number of a point in the space that the mesh is placed in. At a point of the mesh any of the
  /// numbers around it.
  double at(const V3d& p) const;

  /// The first term that is left out is up to 3 (r/d)^2 of a group's share (its area over 4 pi d^2), where
  /// r^2 is the mean square of its extent: half of (d / kFar)^2 at most, for one that is flat. kError is that
  /// of shares that are one together.
  static constexpr double kFar = 6, kError = 1.5 / (kFar * kFar);

 private:
  struct Group {
    double area = 0, radius = 0;           // the radius is about the centre, of all corners
    V3d centre{0, 0, 0}, normal{0, 0, 0};  // mean of the triangles' centres by area; sum of area times normal
    double moment[9] = {};                 // sum of (a triangle's centre - centre) times (area times normal)
  };
  Group triangle_group(const Primitive& triangle) const;
  /// One group of some.
  static Group joined(std::span<const Group> parts);
  double far_away(const Group& group, const V3d& p) const;

  std::vector<Primitive> triangles_;
  Bvh tree_;
  std::vector<Group> groups_;  // two for each node: its children
};

/// The solid angle of a triangle seen from the origin, from -2 pi to 2 pi [VanOosterom1983].
double solid_angle(const V3d& a, const V3d& b, const V3d& c);

}  // namespace tessera::render
