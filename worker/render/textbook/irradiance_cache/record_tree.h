// A hierarchy of boxes over the spheres that records reach.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/textbook/irradiance_cache/record_site.h"

namespace tessera::render::TESSERA_ISA {

class RecordTree {
 public:
  RecordTree() = default;
  /// Sites reach as far as their error may be below `error`.
  RecordTree(std::span<const RecordSite> sites, float error);

  /// The sites by their place in the leaves: whoever visits them has to put what belongs to them into this
  /// order.
  const std::vector<std::uint32_t>& order() const { return order_; }

  /// Calls visit(i) for all places in the leaves whose sites may reach some of the points; those that reach a
  /// point come in the same order whatever the other lanes hold.
  template <class Visit>
  void visit(Vec3 p, Mask active, Visit&& visit) const {
    if (nodes_.empty()) return;
    std::int32_t waiting[kDeepest];
    int size = 0;
    waiting[size++] = 0;
    while (size > 0) {
      const std::int32_t index = waiting[--size];
      const Node& node = nodes_[static_cast<std::size_t>(index)];
      const Mask inside = active & (p.x >= node.low[0]) & (p.x <= node.high[0]) & (p.y >= node.low[1]) &
                          (p.y <= node.high[1]) & (p.z >= node.low[2]) & (p.z <= node.high[2]);
      if (none(inside)) continue;
      for (std::int32_t i = 0; i < node.count; ++i) visit(static_cast<std::size_t>(node.first + i));
      if (node.other < 0) continue;
      waiting[size++] = node.other;
      waiting[size++] = index + 1;
    }
  }

 private:
  static constexpr std::size_t kDeepest = 64;  // nodes one within the other: each halves its sites

  /// A box around the spheres that the sites from `first` on reach. Leaves have `count` of them; else the
  /// next node is the one child, and `other` the second.
  struct Node {
    float low[3], high[3];
    std::int32_t first, count, other;
  };
  void build(std::span<const RecordSite> sites, float error, std::size_t begin, std::size_t end);

  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

/// `items` by their place in the leaves.
template <class T>
std::vector<T> in_order(const std::vector<T>& items, const RecordTree& tree) {
  std::vector<T> result;
  result.reserve(items.size());
  for (const std::uint32_t i : tree.order()) result.push_back(items[i]);
  return result;
}

}  // namespace tessera::render::TESSERA_ISA
