// Patches: the triangles of a scene, each side by itself, split into four as often as links ask for
// [Hanrahan, Salzman & Aupperle 1991]. Every machine makes the same patches of a scene, and gives them the
// same names.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/core/vec64.h"
#include "render/shape/shape_table.h"
#include "wire/phases/patch_name.h"

namespace tessera::render::TESSERA_ISA::radiosity {

using vec64::Vec;

using Side = wire::TriangleSide;
using Name = wire::PatchName;

/// Weights of a triangle's corners at a point of it.
struct Weights {
  double w[3] = {0, 0, 0};
};

/// The patch's corners, in weights of those of its triangle.
struct Corners {
  Weights at[3];
};
Corners corners_of(Name patch);

/// Render space.
struct Patch {
  Vec corner[3];
  Vec normal;  // unit; on the side that the patch is
  double area = 0;

  Vec point(const Weights& at) const {
    return corner[0] * at.w[0] + corner[1] * at.w[1] + corner[2] * at.w[2];
  }
  Vec centre() const { return point({{1 / 3.0, 1 / 3.0, 1 / 3.0}}); }
  /// Radius of a sphere about the centre that holds the patch.
  double radius() const;
};

/// All triangles of a scene, those of instances where they are placed.
class Surfaces {
 public:
  explicit Surfaces(const ShapeTable& shapes);

  Side sides() const { return 2 * static_cast<Side>(triangles_.size()); }
  double area(Side side) const { return triangles_[side / 2].area; }
  /// The triangle's corners go clockwise, seen from where its side 0 is: an instance has mirrored it.
  bool is_turned(Side side) const { return triangles_[side / 2].turned; }
  /// Area of one side of everything.
  double whole_area() const { return whole_area_; }
  Patch patch(Name name) const;

  /// The triangle that a ray met: `side` 0 of it.
  Side side_of_hit(std::int32_t shape, std::int32_t primitive, std::int32_t instance) const {
    const std::size_t placed =
        instance < 0 ? static_cast<std::size_t>(shape)
                     : first_placed_[static_cast<std::size_t>(instance)] + static_cast<std::size_t>(shape);
    return 2 * (first_triangle_[placed] + static_cast<Side>(primitive));
  }
  struct Origin {
    std::int32_t shape, primitive, instance;
  };
  Origin origin(Side side) const { return triangles_[side / 2].origin; }

 private:
  struct Triangle {
    Vec corner[3];
    Vec normal;
    double area;
    Origin origin;
    bool turned;
  };
  void add_shape(const ShapeTable& shapes, std::size_t shape, std::int32_t instance);

  std::vector<Triangle> triangles_;
  /// Numbers of the first triangles of all shapes in the world, then of those that each instance places.
  std::vector<Side> first_triangle_;
  /// For each instance, what is added to a shape's number for its place in first_triangle_.
  std::vector<std::size_t> first_placed_;
  double whole_area_ = 0;
};

}  // namespace tessera::render::TESSERA_ISA::radiosity
