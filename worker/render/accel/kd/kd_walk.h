#pragma once

#include "render/accel/kd/kd_tree.h"
#include "render/accel/structure/ray.h"
#include "render/accel/wide/wide_walk.h"

namespace tessera::render::TESSERA_ISA {

/// Cells in the order in which the ray passes them [Havran2000, sec. 4.1], each with the part of the ray that
/// lies in it. The plane is as thick as a box's border is wide, so parts of neighbours overlap.
template <class Visitor>
void walk(const KdTree& tree, const Box& box, const Ray& ray, Visitor& visitor) {
  if (!tree.wide.nodes.empty()) return walk_wide(tree.wide, ray, visitor);
  struct Waiting {
    std::int32_t child;
    float enter, leave;
  };
  constexpr int kDeepest = 64;  // 8 + 1.3 log2 of 2^30 is 47
  Waiting stack[kDeepest];
  int waiting = 0;
  const Ray::Interval whole = ray.within(box.low, box.high);
  if (whole.empty()) return;
  Waiting at{tree.root, whole.enter, whole.leave};
  for (;;) {
    if (at.child >= 0) {
      visitor.enter();
      const KdNode& node = tree.nodes[static_cast<std::size_t>(at.child)];
      const float inverse = ray.inverse[node.axis];
      const int near = inverse < 0 ? 1 : 0;
      // Where the ray comes to the plane, and where it has passed it.
      const float a = (node.split - ray.low_o[node.axis]) * inverse;
      const float b = (node.split - ray.high_o[node.axis]) * inverse;
      const float come = near == 0 ? a : b, passed = near == 0 ? b : a;
      const bool meets_near = passed >= at.enter, meets_far = come <= at.leave;
      if (meets_near) {
        if (meets_far) stack[waiting++] = {node.child[1 - near], std::max(at.enter, come), at.leave};
        at = {node.child[near], at.enter, std::min(at.leave, passed)};
        continue;
      }
      if (meets_far) {
        at = {node.child[1 - near], std::max(at.enter, come), at.leave};
        continue;
      }
    } else {
      for (const std::uint32_t i : tree.items_of(at.child)) {
        if (visitor.meet(i)) return;
      }
    }
    do {
      if (waiting == 0) return;
      at = stack[--waiting];
    } while (at.enter > visitor.reach());
  }
}

}  // namespace tessera::render::TESSERA_ISA
