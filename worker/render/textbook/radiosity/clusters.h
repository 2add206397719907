// Clusters of sides: a tree over all of them, so that what is far away or dark gives its light as one
// [Smits, Arvo & Greenberg 1994].
#pragma once

#include <cstdint>
#include <vector>

#include "render/textbook/radiosity/patches.h"

namespace tessera::render::TESSERA_ISA::radiosity {

struct Cluster {
  Vec centre;  // centre of a sphere that holds all of its sides
  double radius = 0;
  double area = 0;                     // sum over its sides
  std::uint32_t first = 0, count = 0;  // range of its sides in Clusters::order_
  std::uint32_t children[2] = {0, 0};  // clusters of more than one side: numbers of the two halves
};

class Clusters {
 public:
  explicit Clusters(const Surfaces& surfaces);

  /// The first is the whole scene; children come after their parents.
  const std::vector<Cluster>& all() const { return clusters_; }
  bool empty() const { return clusters_.empty(); }
  /// Child `i` of a cluster: one of its two clusters, or its only side (both are that, then).
  Name child(std::uint32_t cluster, int i) const;
  /// The side that has its share of the cluster's area at `u` in [0, 1), which becomes uniform there.
  Side side_at(const Cluster& cluster, double& u) const;
  Side only_side(const Cluster& cluster) const { return order_[cluster.first]; }

 private:
  void build(const Surfaces& surfaces, const std::vector<Vec>& centres, std::uint32_t cluster);
  void bound(const Surfaces& surfaces, Cluster& cluster) const;

  std::vector<Cluster> clusters_;
  std::vector<Side> order_;
  std::vector<double> area_before_;  // [i]: sum over the sides before order_[i]
};

}  // namespace tessera::render::TESSERA_ISA::radiosity
