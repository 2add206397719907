#include "render/transport/guide/guide_density.h"

#include <utility>

namespace tessera::render::TESSERA_ISA {

std::vector<double> guide_density(std::span<const GuideTally> bins) {
  // Sums over squares of 1, 2, 4, ... bins a side.
  std::vector<std::vector<GuideTally>> pyramid{{bins.begin(), bins.end()}};
  for (std::size_t side = kGuideRows / 2; side > 0; side /= 2) {
    std::vector<GuideTally> upper(side * side);
    for (std::size_t i = 0; i < pyramid.back().size(); ++i) {
      const GuideTally& part = pyramid.back()[i];
      GuideTally& whole = upper[i / (2 * side) / 2 * side + i % (2 * side) / 2];
      whole.value += part.value, whole.count += part.count;
    }
    pyramid.push_back(std::move(upper));
  }
  std::vector<double> share{1};
  for (std::size_t side = 2; side <= kGuideRows; side *= 2) {
    const std::vector<GuideTally> whole = std::move(pyramid.back());
    pyramid.pop_back();
    std::vector<double> parts(side * side);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const std::size_t above = i / side / 2 * (side / 2) + i % side / 2;
      const GuideTally& light = whole[above];
      const double even = light.value > 0 ? kGuideSmoothing / (kGuideSmoothing + light.count) : 1;
      const double own = light.value > 0 ? pyramid.back()[i].value / light.value : 0;
      parts[i] = share[above] * (even / 4 + (1 - even) * own);
    }
    share = std::move(parts);
  }
  return share;
}

}  // namespace tessera::render::TESSERA_ISA
