#pragma once

#include "render/accel/octree/octree.h"
#include "render/accel/structure/ray.h"

namespace tessera::render::TESSERA_ISA {

/// The eight children of a cell in an order that is front to back for every ray of the same octant of
/// directions: by how many, and which, of the three middle planes lie before them [Revelles, Urena & Lastra
/// 2000]. The planes are as thick as a box's border is wide.
template <class Visitor>
void walk(const Octree& tree, const Box& box, const Ray& ray, Visitor& visitor) {
  struct Waiting {
    std::int32_t child;
    float enter, leave;
  };
  constexpr int kMostWaiting = 7 * 21 + 1;  // seven siblings for each step down
  Waiting stack[kMostWaiting];
  int waiting = 0;
  const Ray::Interval whole = ray.within(box.low, box.high);
  if (whole.empty()) return;
  stack[waiting++] = {tree.root, whole.enter, whole.leave};
  const int mirrored =
      (ray.inverse[0] < 0 ? 1 : 0) | (ray.inverse[1] < 0 ? 2 : 0) | (ray.inverse[2] < 0 ? 4 : 0);
  while (waiting > 0) {
    const Waiting at = stack[--waiting];
    if (at.enter > visitor.reach()) continue;
    if (at.child < 0) {
      for (const std::uint32_t i : tree.items_of(at.child)) {
        if (visitor.meet(i)) return;
      }
      continue;
    }
    visitor.enter();
    const OctreeNode& node = tree.nodes[static_cast<std::size_t>(at.child)];
    float come[3], passed[3];
    for (int k = 0; k < 3; ++k) {
      come[k] = (node.centre[k] - ray.low_o[k]) * ray.inverse[k];
      passed[k] = (node.centre[k] - ray.high_o[k]) * ray.inverse[k];
      if (ray.inverse[k] < 0) std::swap(come[k], passed[k]);
    }
    for (int octant = 7; octant >= 0; --octant) {
      Waiting next{node.child[octant ^ mirrored], at.enter, at.leave};
      for (int k = 0; k < 3; ++k) {
        if (octant >> k & 1) {
          next.enter = std::max(next.enter, come[k]);
        } else {
          next.leave = std::min(next.leave, passed[k]);
        }
      }
      if (next.enter <= next.leave) stack[waiting++] = next;
    }
  }
}

}  // namespace tessera::render::TESSERA_ISA
