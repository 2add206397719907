#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "render/accel/sphere_tree/sphere_tree.h"
#include "render/accel/structure/ray.h"

namespace tessera::render::TESSERA_ISA {

/// Where a ray comes into a sphere that is wider by its padding, from the origin on, or nothing. In double,
/// and taken to be earlier by more than a square root can be off.
inline std::optional<double> enters(const Ray& ray, double inverse_squared, const SphereNode& node) {
  if (node.radius < 0) return std::nullopt;
  double along = 0, apart = 0;
  double to[3];
  for (int k = 0; k < 3; ++k) {
    to[k] = node.centre[k] - ray.o[k];
    along += to[k] * ray.d[k];
  }
  const double middle = along * inverse_squared;
  for (int k = 0; k < 3; ++k) {
    const double off = to[k] - middle * ray.d[k];
    apart += off * off;
  }
  const double radius = double{node.radius} + 2.0 * ray.pad;
  const double rest = radius * radius - apart;
  if (rest < 0) return std::nullopt;
  const double half = std::sqrt(rest * inverse_squared);
  if (middle + half < 0) return std::nullopt;
  return std::max(0.0, (middle - half) - 0x1p-22 * std::abs(middle));
}

/// Best first: whatever sphere a ray comes into next is opened next, so that no sphere behind the hit is ever
/// opened. The heap is the price.
template <class Visitor>
void walk(const SphereTree& tree, const Box&, const Ray& ray, Visitor& visitor) {
  struct Waiting {
    double enter;
    std::int32_t node;
    bool operator<(const Waiting& other) const { return enter > other.enter; }  // the heap's top is the least
  };
  const double inverse_squared = 1 / (ray.d[0] * ray.d[0] + ray.d[1] * ray.d[1] + ray.d[2] * ray.d[2]);
  std::vector<Waiting> heap;
  const auto consider = [&](std::int32_t i) {
    const auto enter = enters(ray, inverse_squared, tree.nodes[static_cast<std::size_t>(i)]);
    if (!enter || *enter > visitor.reach()) return;
    heap.push_back({*enter, i});
    std::push_heap(heap.begin(), heap.end());
  };
  consider(0);
  while (!heap.empty() && heap.front().enter <= visitor.reach()) {
    const SphereNode& node = tree.nodes[static_cast<std::size_t>(heap.front().node)];
    std::pop_heap(heap.begin(), heap.end());
    heap.pop_back();
    visitor.enter();
    if (node.child[1] >= 0) {
      for (const std::int32_t child : node.child) consider(child);
      continue;
    }
    for (std::int32_t i = 0; i < ~node.child[1]; ++i) {
      if (visitor.meet(static_cast<std::uint32_t>(node.child[0] + i))) return;
    }
  }
}

}  // namespace tessera::render::TESSERA_ISA
