#pragma once

#include "render/accel/bsp/bsp_tree.h"
#include "render/accel/structure/ray.h"

namespace tessera::render::TESSERA_ISA {

/// Walk like that of a kd-tree, with planes that need a dot product each, in double.
template <class Visitor>
void walk(const BspTree& tree, const Box& box, const Ray& ray, Visitor& visitor) {
  struct Waiting {
    std::int32_t child;
    double enter, leave;
  };
  constexpr int kDeepest = 64;  // 16 + 1.5 log2 of 2^30 is 61
  Waiting stack[kDeepest];
  int waiting = 0;
  const Ray::Interval whole = ray.within(box.low, box.high);
  if (whole.empty()) return;
  Waiting at{tree.root, whole.enter, whole.leave};
  for (;;) {
    if (at.child >= 0) {
      visitor.enter();
      const BspNode& node = tree.nodes[static_cast<std::size_t>(at.child)];
      double speed = 0, height = -double{node.place};
      for (int k = 0; k < 3; ++k) {
        speed += double{node.normal[k]} * ray.d[k];
        height += double{node.normal[k]} * ray.o[k];
      }
      // Where the ray comes to within `pad` of the plane, and where it has left that; both are infinite where
      // it runs along it.
      const double turned = speed < 0 ? -height : height, inverse = 1 / std::abs(speed);
      const int near = speed < 0 ? 1 : 0;
      double come = (-turned - ray.pad) * inverse, passed = (-turned + ray.pad) * inverse;
      if (speed == 0) {
        come = height >= -double{ray.pad} ? -HUGE_VAL : HUGE_VAL;
        passed = height <= double{ray.pad} ? HUGE_VAL : -HUGE_VAL;
      }
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
    } while (at.enter > double{visitor.reach()} * (1 + 0x1p-20));
  }
}

}  // namespace tessera::render::TESSERA_ISA
