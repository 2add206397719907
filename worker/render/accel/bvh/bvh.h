// Bounding volume hierarchy [KayKajiya1986; GoldsmithSalmon1987]: a binary tree of boxes, over
// primitives that lie in leaves once each.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <stop_token>
#include <vector>

#include "absl/status/status.h"
#include "render/accel/structure/figures.h"
#include "render/accel/structure/primitive.h"
#include "render/accel/structure/structure_options.h"
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
  WideTree wide;            // the same tree folded wide; empty unless it was asked for
  BigArray<BvhNode> nodes;  // depth first, the root first; none where there are no primitives
  StructureFigures figures;
};

/// How a set of primitives is parted.
enum class BvhRule {
  kMedian,  // along the longest axis at the median object
  kSah,     // cut where the surface area heuristic finds least cost
};

/// Leaves of kMedian hold up to so many; those of kSah as many as the heuristic likes, up to kMostInLeaf.
inline constexpr std::size_t kMedianLeaf = 4, kMostInLeaf = 16;
/// A walk's stack holds one node for each step down.
inline constexpr int kBvhDepth = 96;

/// Brings the primitives into the order of the leaves. The same tree for any number of threads. Like all
/// builders of structures, throws Stopped once a stop is requested.
Bvh build_bvh(BvhRule rule, std::vector<Primitive>& primitives, int threads, std::stop_token stop = {});

absl::Status build_tree(const StructureOptions& options, std::vector<Primitive>& primitives, Bvh& tree,
                        BvhRule rule);

Box child_box(const BvhNode& node, int c);

/// Makes `tree.wide` of its nodes.
void widen(const std::vector<Primitive>& primitives, Bvh& tree, std::stop_token stop = {});

/// One primitive while a tree is built.
struct BvhRef {
  Box box;
  std::uint32_t index;
};

/// A box that is added up four numbers at a time.
class WideBox {
 public:
  void add(const Box& box) {
    Four low, high;
    static_assert(sizeof(Box) == 24);  // three lower ends, then three upper ones
    std::memcpy(&low, box.low, sizeof(low));
    std::memcpy(&high, box.low + 2, sizeof(high));
    low_ = low < low_ ? low : low_;
    high_ = high > high_ ? high : high_;
  }
  Box box() const { return {{low_[0], low_[1], low_[2]}, {high_[1], high_[2], high_[3]}}; }
  /// Adds the centre of a box instead, which is Box::centre() to the bit; only for box_of_points().
  void add_point(const Box& box) {
    Four low, high;
    std::memcpy(&low, box.low, sizeof(low));
    std::memcpy(&high, box.low + 2, sizeof(high));
    const Four ends = __builtin_shufflevector(high, high, 1, 2, 3, 3);
    const Four centre = 0.5f * low + 0.5f * ends;
    low_ = centre < low_ ? centre : low_;
    high_ = centre > high_ ? centre : high_;
  }
  Box box_of_points() const { return {{low_[0], low_[1], low_[2]}, {high_[0], high_[1], high_[2]}}; }

 private:
  using Four = float __attribute__((vector_size(16)));
  static constexpr float kFar = Box::kInfinity;
  // A lane of each holds an end of the other sort.
  Four low_ = {kFar, kFar, kFar, kFar}, high_ = {-kFar, -kFar, -kFar, -kFar};
};

/// Bounds of the boxes of a set, and of their centres.
struct BvhBounds {
  Box box, centres;
};

/// Bounds that are added up four numbers at a time.
class WideBounds {
 public:
  void add(const BvhRef& ref) {
    boxes_.add(ref.box);
    centres_.add_point(ref.box);
  }
  BvhBounds bounds() const { return {boxes_.box(), centres_.box_of_points()}; }

 private:
  WideBox boxes_, centres_;
};

/// The two ways to part a set: brings `refs` into an order whose first so many are the left half; 0 where the
/// set should be a leaf. `bounds` are the set's; the second way gives those of both halves.
std::size_t part_at_median(std::span<BvhRef> refs, const Box& centres);
std::size_t part_by_sah(std::span<BvhRef> refs, const BvhBounds& bounds, BvhBounds (&halves)[2]);
BvhBounds bounds_of(std::span<const BvhRef> refs);

/// Sets up to this size are swept.
inline constexpr std::size_t kSweptSize = 64;

/// A small set that is parted down to its leaves by exact sweeps: it is sorted along each axis once, and what
/// parts keep that order.
class SweptSet {
 public:
  explicit SweptSet(std::span<BvhRef> refs);

  /// Parts `n` from `first` on, of which `box` is the box, where the heuristic finds least cost; the number
  /// that comes first, or 0 where they should be a leaf.
  std::size_t part(std::size_t first, std::size_t n, const Box& box);
  /// The same at the median object.
  std::size_t halve(std::size_t first, std::size_t n);
  Box box_of(std::size_t first, std::size_t n) const;
  /// Brings the refs of a leaf to their place.
  void put_back(std::size_t first, std::size_t n);

 private:
  void part_along(std::size_t axis, std::size_t first, std::size_t n, std::size_t left);

  const std::span<BvhRef> refs_;
  std::array<BvhRef, kSweptSize> copies_;
  std::array<std::array<std::uint8_t, kSweptSize>, 3> order_;
};

}  // namespace tessera::render
