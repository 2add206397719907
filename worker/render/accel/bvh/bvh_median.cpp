// Halves a set along the longest axis at the median object [KayKajiya1986].
#include "render/accel/bvh/bvh.h"

namespace tessera::render {

std::size_t part_at_median(std::span<BvhRef> refs, const Box& centres) {
  const int axis = centres.longest_axis();
  const std::size_t half = refs.size() / 2;
  // Equal centres are sorted by number: identical primitives part evenly, and always the same way.
  std::nth_element(refs.begin(), refs.begin() + static_cast<std::ptrdiff_t>(half), refs.end(),
                   [axis](const BvhRef& a, const BvhRef& b) {
                     const float ca = a.box.centre(axis), cb = b.box.centre(axis);
                     return ca != cb ? ca < cb : a.index < b.index;
                   });
  return half;
}

}  // namespace tessera::render
