// The structure that queries search: hierarchies of boxes over all that a line may cross, none left out for
// its size.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "render/accel/bvh/bvh.h"
#include "render/accel/structure/primitive_list.h"
#include "render/accel/structure/scene_structure.h"
#include "render/shape/exact_affine.h"
#include "render/shape/shape_table.h"

namespace tessera::render {

/// A level over the world and one over each object, as accel/structure has them. Other than those it holds
/// triangles without a normal, so that closed meshes stay closed; curves, which face whoever looks, are not
/// in it.
class QueryStructure {
 public:
  /// The table must outlive the result. ResourceExhausted where there are too many primitives.
  static absl::StatusOr<QueryStructure> build(const ShapeTable& table, const AnalyticBounds& analytic,
                                              int threads);

  const ShapeTable& shapes() const { return *shapes_; }
  const Level<Bvh>& world() const { return world_; }
  const Level<Bvh>& object(std::int32_t i) const { return objects_[static_cast<std::size_t>(i)]; }
  ExactAffine render_from_instance(std::int32_t instance, float time) const {
    return placement_at(*shapes_, shapes_->instances[static_cast<std::size_t>(instance)], time);
  }
  ExactAffine instance_from_render(std::int32_t instance, float time) const {
    const bool still = shapes_->instances[static_cast<std::size_t>(instance)].segments == 0;
    return still ? instance_from_render_[static_cast<std::size_t>(instance)]
                 : inverse(render_from_instance(instance, time));
  }

 private:
  absl::Status add_shapes(std::int32_t first, std::int32_t count, const AnalyticBounds& analytic,
                          Level<Bvh>& level) const;
  static absl::Status finish(Level<Bvh>& level, int threads);

  const ShapeTable* shapes_ = nullptr;
  Level<Bvh> world_;
  std::vector<Level<Bvh>> objects_;
  std::vector<ExactAffine> instance_from_render_;  // instances that stand still
};

/// Corners of triangle `number` of a mesh, as floats in the space that it is placed in.
void triangle_corners(const ShapeTable& table, const ShapeRecord& mesh, std::int32_t number,
                      float (&corners)[3][3]);

}  // namespace tessera::render
