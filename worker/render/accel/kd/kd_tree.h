// kd-tree [Bentley1975; Kaplan1985]: space is parted by planes across the axes, and a primitive lies in
// every cell that it reaches into.
#pragma once

#include <stop_token>

#include "absl/status/status.h"
#include "render/accel/structure/cell_tree.h"
#include "render/accel/structure/forks.h"
#include "render/accel/structure/structure_options.h"
#include "render/accel/wide/wide_tree.h"

namespace tessera::render {

struct KdNode {
  float split = 0;  // the plane's place along `axis`
  std::int32_t axis = 0;
  std::int32_t child[2] = {-1, -1};  // below the plane, and above it (CellTree)
};
struct KdTree : CellTree<KdNode> {
  WideTree wide;  // the same tree folded wide; empty unless it was asked for
};

/// How a cell is parted.
enum class KdRule {
  kMedian,  // axes take turns; at the median of what lies in it
  kSah,     // cut where the surface area heuristic finds least cost
};

/// A primitive while a tree is built: bounds of its part within the cell.
struct KdRef {
  Box part;
  std::uint32_t index;
};

/// A plane, and what it is thought to cost to have it.
struct KdSplit {
  int axis = -1;  // -1: none
  float place = 0;
  double cost = std::numeric_limits<double>::infinity();
  bool flat_below = true;  // Triangles that lie in the plane go to the cell below.
};

/// The two ways to choose a plane for a cell.
KdSplit split_at_median(const std::vector<KdRef>& refs, const Box& cell, int depth,
                        const std::stop_token& stop);
KdSplit split_by_sah(const std::vector<KdRef>& refs, const Box& cell, const std::stop_token& stop);

/// 8 + 1.3 log2 n [Havran2000].
int kd_depth(std::size_t n);

/// The same tree for any number of threads.
KdTree build_kd_tree(KdRule rule, const std::vector<Primitive>& primitives, int threads,
                     std::stop_token stop = {});

/// Makes `tree.wide` of its nodes.
void widen(const std::vector<Primitive>& primitives, KdTree& tree, std::stop_token stop = {});

absl::Status build_tree(const StructureOptions& options, std::vector<Primitive>& primitives, KdTree& tree,
                        KdRule rule);

/// Expected cost of a ray that meets the tree's box.
double kd_sah_cost(const KdTree& tree);

/// Figures of the cells and of the tree folded wide, and the cost.
StructureFigures figures_of(const KdTree& tree);

}  // namespace tessera::render
