// BSP tree with planes that stand freely [Fuchs, Kedem & Naylor 1980; for rays Ize, Wald & Parker 2008].
#pragma once

#include <stop_token>

#include "absl/status/status.h"
#include "render/accel/structure/cell_tree.h"
#include "render/accel/structure/structure_options.h"

namespace tessera::render {

/// The plane normal . x = place; child 0 is where less is.
struct BspNode {
  float normal[3] = {0, 0, 0};
  float place = 0;
  std::int32_t child[2] = {-1, -1};  // CellTree
};
using BspTree = CellTree<BspNode>;

/// The same tree for any number of threads.
BspTree build_bsp_tree(const std::vector<Primitive>& primitives, int threads, std::stop_token stop = {});
absl::Status build_tree(const StructureOptions& options, std::vector<Primitive>& primitives, BspTree& tree);

}  // namespace tessera::render
