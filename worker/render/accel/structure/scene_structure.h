// A scene in a structure of the courses: one over the world, and one over each object that instances place.
#pragma once

#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "render/accel/brute/brute.h"
#include "render/accel/bsp/bsp_tree.h"
#include "render/accel/bvh/bvh.h"
#include "render/accel/grid/grid.h"
#include "render/accel/kd/kd_tree.h"
#include "render/accel/octree/octree.h"
#include "render/accel/ray_query.h"
#include "render/accel/ray_structure.h"
#include "render/accel/sphere_tree/sphere_tree.h"
#include "render/accel/structure/figures.h"
#include "render/accel/structure/primitive_list.h"
#include "render/shape/exact_affine.h"

namespace tessera::render {

struct ShapeTable;
struct TextureTable;

/// All but Embree's. BVH and kd-tree are built in two ways each.
enum class StructureKind {
  kBrute,
  kBvhMedian,
  kBvhSah,
  kSphereTree,
  kGrid,
  kOctree,
  kBsp,
  kKdMedian,
  kKdSah
};

struct StructureOptions {
  int threads = 1;
  bool wide = false;  // sixteen boxes at a step, where a structure can (BVH); else as it is read
  double grid_density = kGridDensity;  // cells a primitive
  bool shadow_cache = false;           // shadow rays are tested against the last occluder first
  std::stop_token stop = {};
};

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
  std::vector<Primitive> primitives;  // in the tree's order, where it has one
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
