#include "render/textbook/irradiance_cache/record_tree.h"

#include <algorithm>
#include <numeric>

namespace tessera::render::TESSERA_ISA {

RecordTree::RecordTree(std::span<const RecordSite> sites, float error) : order_(sites.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  if (!sites.empty()) build(sites, error, 0, sites.size());
}

void RecordTree::build(std::span<const RecordSite> sites, float error, std::size_t begin, std::size_t end) {
  constexpr std::size_t kLeaf = 4;  // sites
  const std::size_t index = nodes_.size();
  nodes_.push_back({.low = {1e30f, 1e30f, 1e30f},
                    .high = {-1e30f, -1e30f, -1e30f},
                    .first = static_cast<std::int32_t>(begin),
                    .count = static_cast<std::int32_t>(end - begin),
                    .other = -1});
  float low[3] = {1e30f, 1e30f, 1e30f}, high[3] = {-1e30f, -1e30f, -1e30f};  // bounds of the sites' places
  for (std::size_t i = begin; i < end; ++i) {
    const RecordSite& site = sites[order_[i]];
    Node& node = nodes_[index];
    // Rounding must not lose what the error would still allow.
    const float reach = reach_of(site, error) * 1.0001f;
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], site.p[axis]), high[axis] = std::max(high[axis], site.p[axis]);
      node.low[axis] = std::min(node.low[axis], site.p[axis] - reach);
      node.high[axis] = std::max(node.high[axis], site.p[axis] + reach);
    }
  }
  if (end - begin <= kLeaf) return;
  int longest = 0;
  for (int axis = 1; axis < 3; ++axis) {
    if (high[axis] - low[axis] > high[longest] - low[longest]) longest = axis;
  }
  const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
  // Stable, so that records at one place keep their order with every library.
  std::stable_sort(at(begin), at(end), [&](std::uint32_t a, std::uint32_t b) {
    return sites[a].p[longest] < sites[b].p[longest];
  });
  const std::size_t middle = begin + (end - begin) / 2;
  build(sites, error, begin, middle);
  nodes_[index].count = 0;
  nodes_[index].other = static_cast<std::int32_t>(nodes_.size());
  build(sites, error, middle, end);
}

}  // namespace tessera::render::TESSERA_ISA
