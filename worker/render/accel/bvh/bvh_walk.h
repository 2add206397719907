#pragma once

#include "render/accel/bvh/bvh.h"
#include "render/accel/structure/ray.h"
#include "render/accel/wide/wide_walk.h"

namespace tessera::render::TESSERA_ISA {

/// Both boxes of a node against a ray, in the four lanes of one vector: lower ends of both, upper ends of
/// both.
class BoxPair {
 public:
  explicit TESSERA_INLINE BoxPair(const Ray& ray) {
    for (int k = 0; k < 3; ++k) {
      const float o[4] = {ray.low_o[k], ray.low_o[k], ray.high_o[k], ray.high_o[k]};
      origin_[k] = hn::LoadU(Four(), o);
      inverse_[k] = hn::Set(Four(), ray.inverse[k]);
    }
  }

  /// Lanes 0 and 1 of `enter` and `leave` are where the ray is in each box, within [0, reach]: in none where
  /// it leaves before it enters.
  TESSERA_INLINE void meet(const BvhNode& node, float reach, float (&enter)[4], float (&leave)[4]) const {
    auto nearest = hn::Zero(Four()), farthest = hn::Set(Four(), reach);
    for (int k = 0; k < 3; ++k) {
      const auto t = hn::Mul(hn::Sub(hn::Load(Four(), node.planes[k]), origin_[k]), inverse_[k]);
      const auto other = hn::Shuffle1032(t);
      nearest = hn::Max(nearest, hn::Min(t, other));
      farthest = hn::Min(farthest, hn::Max(t, other));
    }
    hn::StoreU(nearest, Four(), enter);
    hn::StoreU(farthest, Four(), leave);
  }

 private:
  using Four = hn::FixedTag<float, 4>;
  hn::Vec<Four> origin_[3], inverse_[3];
};

/// A node or a leaf that a walk has still to see.
struct WaitingChild {
  std::int32_t child, count;
  float enter;
};

/// Shows the primitives of a leaf; true where the walk may end.
template <class Visitor>
TESSERA_INLINE bool meet_leaf(const WaitingChild& leaf, Visitor& visitor) {
  const auto begin = static_cast<std::uint32_t>(~leaf.child);
  for (std::uint32_t i = begin; i < begin + static_cast<std::uint32_t>(leaf.count); ++i) {
    if (visitor.meet(i)) return true;
  }
  return false;
}

/// Front to back: the nearer child first, the other waits on a stack and is left out when something nearer
/// has been met by then.
template <class Visitor>
void walk_pairs(const Bvh& tree, const Ray& ray, Visitor& visitor) {
  WaitingChild stack[kBvhDepth + 1];
  int waiting = 0;
  const BoxPair boxes(ray);
  WaitingChild at{0, 0, 0};
  for (;;) {
    if (at.child >= 0) {
      visitor.enter();
      const BvhNode& node = tree.nodes[static_cast<std::size_t>(at.child)];
      float enter[4], leave[4];
      boxes.meet(node, visitor.reach(), enter, leave);
      const bool meets[2] = {enter[0] <= leave[0], enter[1] <= leave[1]};
      const int first = meets[0] && !(meets[1] && enter[1] < enter[0]) ? 0 : 1;
      if (meets[first]) {
        const int last = 1 - first;
        if (meets[last]) stack[waiting++] = {node.child[last], node.count[last], enter[last]};
        at = {node.child[first], node.count[first], enter[first]};
        continue;
      }
    } else if (meet_leaf(at, visitor)) {
      return;
    }
    do {
      if (waiting == 0) return;
      at = stack[--waiting];
    } while (at.enter > visitor.reach());
  }
}

template <class Visitor>
void walk(const Bvh& tree, const Box&, const Ray& ray, Visitor& visitor) {
  if (!tree.wide.nodes.empty()) return walk_wide(tree.wide, ray, visitor);
  walk_pairs(tree, ray, visitor);
}

}  // namespace tessera::render::TESSERA_ISA
