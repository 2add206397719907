#include "render/textbook/radiosity/clusters.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tessera::render::TESSERA_ISA::radiosity {

Clusters::Clusters(const Surfaces& surfaces) {
  std::vector<Vec> centres(surfaces.sides());
  for (Side side = 0; side < surfaces.sides(); ++side) {
    if (!(surfaces.area(side) > 0)) continue;
    order_.push_back(side);
    centres[side] = surfaces.patch(Name::of_side(side)).centre();
  }
  if (order_.empty()) return;
  clusters_.reserve(2 * order_.size());
  clusters_.push_back({.centre = {}, .count = static_cast<std::uint32_t>(order_.size())});
  // Children are appended, so that this reaches all.
  for (std::uint32_t cluster = 0; cluster < clusters_.size(); ++cluster) build(surfaces, centres, cluster);

  area_before_.resize(order_.size() + 1);
  for (std::size_t i = 0; i < order_.size(); ++i)
    area_before_[i + 1] = area_before_[i] + surfaces.area(order_[i]);
  for (Cluster& cluster : clusters_)
    cluster.area = area_before_[cluster.first + cluster.count] - area_before_[cluster.first];
}

/// Halves the cluster at the median of its sides' centres along its longest axis.
void Clusters::build(const Surfaces& surfaces, const std::vector<Vec>& centres, std::uint32_t index) {
  Cluster cluster = clusters_[index];
  bound(surfaces, cluster);
  if (cluster.count > 1) {
    const auto begin = order_.begin() + cluster.first, end = begin + cluster.count;
    Vec low = centres[*begin], high = low;
    for (auto at = begin; at != end; ++at) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], centres[*at][axis]);
        high[axis] = std::max(high[axis], centres[*at][axis]);
      }
    }
    std::size_t axis = 0;
    for (std::size_t other = 1; other < 3; ++other) {
      if (high[other] - low[other] > high[axis] - low[axis]) axis = other;
    }
    // A total order, so that the halves are the same with every library.
    const std::uint32_t half = cluster.count / 2;
    std::nth_element(begin, begin + half, end, [&](Side a, Side b) {
      return centres[a][axis] != centres[b][axis] ? centres[a][axis] < centres[b][axis] : a < b;
    });
    cluster.children[0] = static_cast<std::uint32_t>(clusters_.size());
    cluster.children[1] = cluster.children[0] + 1;
    clusters_.push_back({.centre = {}, .first = cluster.first, .count = half});
    clusters_.push_back({.centre = {}, .first = cluster.first + half, .count = cluster.count - half});
  }
  clusters_[index] = cluster;
}

void Clusters::bound(const Surfaces& surfaces, Cluster& cluster) const {
  constexpr double kHuge = std::numeric_limits<double>::infinity();
  Vec low{kHuge, kHuge, kHuge}, high{-kHuge, -kHuge, -kHuge};
  for (std::uint32_t i = 0; i < cluster.count; ++i) {
    const Patch patch = surfaces.patch(Name::of_side(order_[cluster.first + i]));
    for (const Vec& corner : patch.corner) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], corner[axis]);
        high[axis] = std::max(high[axis], corner[axis]);
      }
    }
  }
  cluster.centre = (low + high) * 0.5;
  cluster.radius = length(high - low) / 2;
}

Name Clusters::child(std::uint32_t cluster, int i) const {
  const Cluster& it = clusters_[cluster];
  return it.count == 1 ? Name::of_side(order_[it.first]) : Name::of_cluster(it.children[i]);
}

Side Clusters::side_at(const Cluster& cluster, double& u) const {
  const double area = area_before_[cluster.first] + u * cluster.area;
  const auto begin = area_before_.begin() + cluster.first + 1, end = begin + (cluster.count - 1);
  const auto at = static_cast<std::size_t>(std::upper_bound(begin, end, area) - area_before_.begin()) - 1;
  const double own = area_before_[at + 1] - area_before_[at];
  u = std::clamp((area - area_before_[at]) / own, 0.0, std::nextafter(1.0, 0.0));
  return order_[at];
}

}  // namespace tessera::render::TESSERA_ISA::radiosity
