// The list of the structures of the courses. A new one has a folder with its tree, a build_tree() for it and,
// for kernels, a walk(); a value of v1::Accelerator; and three lines here.
#pragma once

#include <tuple>

#include "render/accel/brute/brute.h"
#include "render/accel/bsp/bsp_tree.h"
#include "render/accel/bvh/bvh.h"
#include "render/accel/grid/grid.h"
#include "render/accel/kd/kd_tree.h"
#include "render/accel/octree/octree.h"
#include "render/accel/sphere_tree/sphere_tree.h"
#ifdef TESSERA_ISA
#include "render/accel/brute/brute_walk.h"
#include "render/accel/bsp/bsp_walk.h"
#include "render/accel/bvh/bvh_walk.h"
#include "render/accel/grid/grid_walk.h"
#include "render/accel/kd/kd_walk.h"
#include "render/accel/octree/octree_walk.h"
#include "render/accel/sphere_tree/sphere_walk.h"
#endif

namespace tessera::render {

/// All but Embree's.
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

/// A kind, its word in v1::Accelerator, its tree, and what build_tree() is told besides.
template <StructureKind kKindOfRow, class TreeOfRow, auto... kHow>
struct StructureRow {
  static constexpr StructureKind kKind = kKindOfRow;
  using Tree = TreeOfRow;

  const char* name;

  static absl::Status build(const StructureOptions& options, std::vector<Primitive>& primitives, Tree& tree) {
    return build_tree(options, primitives, tree, kHow...);
  }
};

inline constexpr std::tuple kStructures{
    StructureRow<StructureKind::kBrute, Brute>{"brute"},
    StructureRow<StructureKind::kBvhMedian, Bvh, BvhRule::kMedian>{"bvh-median"},
    StructureRow<StructureKind::kBvhSah, Bvh, BvhRule::kSah>{"bvh-sah"},
    StructureRow<StructureKind::kSphereTree, SphereTree>{"sphere-tree"},
    StructureRow<StructureKind::kGrid, Grid>{"grid"},
    StructureRow<StructureKind::kOctree, Octree>{"octree"},
    StructureRow<StructureKind::kBsp, BspTree>{"bsp"},
    StructureRow<StructureKind::kKdMedian, KdTree, KdRule::kMedian>{"kd-median"},
    StructureRow<StructureKind::kKdSah, KdTree, KdRule::kSah>{"kd-sah"}};

/// Calls f(row) for every row.
template <class F>
void for_each_structure(F&& f) {
  std::apply([&](const auto&... rows) { (f(rows), ...); }, kStructures);
}

/// Calls f(row) for the row of this kind.
template <class F>
void with_structure(StructureKind kind, F&& f) {
  for_each_structure([&](const auto& row) {
    if (row.kKind == kind) f(row);
  });
}

}  // namespace tessera::render
