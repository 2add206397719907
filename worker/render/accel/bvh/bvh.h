// Bounding volume hierarchy [KayKajiya1986; GoldsmithSalmon1987]: a binary tree of boxes, over
// primitives that lie in leaves once each.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/accel/structure/figures.h"
#include "render/accel/structure/primitive.h"
#include "render/accel/wide/wide_tree.h"

namespace tessera::render {

/// A node has the boxes of its children, so that both are decided upon with one read of memory.
struct alignas(64) BvhNode {
  float planes[3][4];     // an axis each: lower ends of both children, then upper ends
  std::int32_t child[2];  // a node; or ~ the first primitive of a leaf
  std::int32_t count[2];  // primitives of a leaf
};
static_assert(sizeof(BvhNode) == 64);

struct Bvh {
  WideTree wide;               // the same tree; empty unless it was asked for
  std::vector<BvhNode> nodes;  // depth first, the root first; none where there are no primitives
  StructureFigures figures;
};

/// How a set of primitives is parted.
enum class BvhRule {
  kMedian,  // along the longest axis at the median object
  kSah,     // where the surface area heuristic finds least cost
};

/// Leaves of kMedian hold up to so many; those of kSah as many as the heuristic likes, up to kMostInLeaf.
inline constexpr std::size_t kMedianLeaf = 4, kMostInLeaf = 16;
/// A walk's stack holds one node for each step down.
inline constexpr int kBvhDepth = 96;

/// Brings the primitives into the order of the leaves. The same tree for any number of threads.
Bvh build_bvh(BvhRule rule, std::vector<Primitive>& primitives, int threads);

Box child_box(const BvhNode& node, int c);

/// Makes `tree.wide` of its nodes.
void widen(const std::vector<Primitive>& primitives, Bvh& tree);

/// One primitive while a tree is built.
struct BvhRef {
  Box box;
  std::uint32_t index;
};

/// The two ways to part a set: brings `refs` into an order whose first so many are the left half; 0 where the
/// set should be a leaf. `centres` bounds the centres of the boxes, `box` the boxes.
std::size_t part_at_median(std::span<BvhRef> refs, const Box& centres);
std::size_t part_by_sah(std::span<BvhRef> refs, const Box& box, const Box& centres);

}  // namespace tessera::render
