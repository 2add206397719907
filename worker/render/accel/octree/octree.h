// Octree [Glassner 1984]: cells are halved along all three axes at once.
#pragma once

#include <stop_token>

#include "absl/status/status.h"
#include "render/accel/structure/cell_tree.h"
#include "render/accel/structure/structure_options.h"

namespace tessera::render {

struct OctreeNode {
  float centre[3] = {0, 0, 0};
  std::int32_t child[8] = {-1, -1, -1, -1,
                           -1, -1, -1, -1};  // bit k: above the centre along axis k (CellTree)
};
using Octree = CellTree<OctreeNode>;

/// The same tree for any number of threads.
Octree build_octree(const std::vector<Primitive>& primitives, int threads, std::stop_token stop = {});
absl::Status build_tree(const StructureOptions& options, std::vector<Primitive>& primitives, Octree& tree);

}  // namespace tessera::render
