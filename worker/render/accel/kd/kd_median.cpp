// Axes take turns; the plane stands where half of the cell's primitives have their centres below it
// [Bentley1975].
#include "render/accel/kd/kd_tree.h"
#include "render/core/stopped.h"

namespace tessera::render {

KdSplit split_at_median(const std::vector<KdRef>& refs, const Box& cell, int depth,
                        const std::stop_token& stop) {
  std::vector<float> centres(refs.size());
  // A turn is passed on where all centres lie in the cell's border.
  for (int turn = 0; turn < 3; ++turn) {
    const int axis = (depth + turn) % 3;
    for (std::size_t i = 0; i < refs.size(); ++i) {
      throw_if_stopped(stop, i);
      centres[i] = refs[i].part.centre(axis);
    }
    const auto half = centres.begin() + static_cast<std::ptrdiff_t>(centres.size() / 2);
    std::nth_element(centres.begin(), half, centres.end());
    if (*half > cell.low[axis] && *half < cell.high[axis]) return {.axis = axis, .place = *half};
  }
  return {};
}

}  // namespace tessera::render
