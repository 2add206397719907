// A scene in a structure of the courses: one over the world, and one over each object that instances place.
#pragma once

#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "render/accel/ray_query.h"
#include "render/accel/ray_structure.h"
#include "render/accel/structure/figures.h"
#include "render/accel/structure/primitive_list.h"
#include "render/accel/structure/structure_list.h"
#include "render/shape/exact_affine.h"

namespace tessera::render {

struct ShapeTable;
struct TextureTable;

/// Asked by kernels, which know from the kind what it holds (structure_query.h).
class SceneStructure : public RayStructure {
 public:
  StructureKind kind() const { return kind_; }
  const ShapeTable& shapes() const { return shapes_; }
  const TextureTable& textures() const { return textures_; }
  bool has_shadow_cache() const { return shadow_cache_; }

  StructureFigures figures() const final { return figures_; }
  std::size_t memory_bytes() const final { return static_cast<std::size_t>(figures_.bytes); }
  float bounding_radius() const final { return radius_; }
  const float* bounding_centre() const final { return centre_; }

 protected:
  SceneStructure(StructureKind kind, const ShapeTable& shapes, const TextureTable& textures)
      : kind_(kind), shapes_(shapes), textures_(textures) {}

  const StructureKind kind_;
  const ShapeTable& shapes_;
  const TextureTable& textures_;
  StructureFigures figures_;
  float radius_ = 0, centre_[3] = {0, 0, 0};
  bool shadow_cache_ = false;
};

/// A list of primitives and what is built over it.
template <class Tree>
struct Level {
  std::vector<Primitive> primitives;  // primitives in the tree's order, where it has one
  Tree tree;
  Box box;
  float largest = 0;  // coordinate of the box
};

template <class Tree>
class TreeStructure final : public SceneStructure {
 public:
  TreeStructure(StructureKind kind, const ShapeTable& shapes, const TextureTable& textures)
      : SceneStructure(kind, shapes, textures) {}

  absl::Status build(const AnalyticBounds& analytic, const StructureOptions& options);

  const Level<Tree>& world() const { return world_; }
  const Level<Tree>& object(std::int32_t i) const { return objects_[static_cast<std::size_t>(i)]; }
  /// Map from render space to that of an instance that stands still.
  const ExactAffine& instance_from_render(std::int32_t i) const {
    return instance_from_render_[static_cast<std::size_t>(i)];
  }
  /// The same of ShapeTable::inner.
  const ExactAffine& inner_from_holder(std::int32_t i) const {
    return inner_from_holder_[static_cast<std::size_t>(i)];
  }

 private:
  absl::Status build_level(const StructureOptions& options, Level<Tree>& level);

  Level<Tree> world_;
  std::vector<Level<Tree>> objects_;
  std::vector<ExactAffine> instance_from_render_, inner_from_holder_;
};

/// The tables must outlive the result. InvalidArgument for shapes that these structures do not know,
/// ResourceExhausted where a bound of memory is reached. Throws Stopped once a stop is requested.
absl::StatusOr<std::unique_ptr<SceneStructure>> build_structure(StructureKind kind, const ShapeTable& shapes,
                                                                const TextureTable& textures,
                                                                const AnalyticBounds& analytic,
                                                                const StructureOptions& options);

/// The part of this room that is compiled once an ISA.
struct StructureKernel {
  AnalyticBounds analytic;
  /// Adds to shapes what they keep in order to be met sooner. Once their table is filled.
  void (*prepare)(ShapeTable& shapes) = nullptr;
  /// Asks a structure, which outlives the query.
  std::unique_ptr<RayQuery> (*make_query)(const SceneStructure& structure) = nullptr;
};

}  // namespace tessera::render
