// A BVH as fold() takes it.
#include <numeric>

#include "render/accel/bvh/bvh.h"
#include "render/core/stopped.h"

namespace tessera::render {

void widen(const std::vector<Primitive>& primitives, Bvh& tree, std::stop_token stop) {
  std::vector<BinaryNode> nodes(std::min<std::size_t>(tree.nodes.size(), 1));
  // Each node is known by its place in `nodes`; those of its children follow when its turn comes.
  std::vector<std::int32_t> origins{0};
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    throw_if_stopped(stop, i);
    if (origins[i] < 0) continue;
    const BvhNode& from = tree.nodes[static_cast<std::size_t>(origins[i])];
    for (int c = 0; c < 2; ++c) {
      nodes[i].child[c] = static_cast<std::int32_t>(nodes.size());
      BinaryNode child;
      if (from.child[c] < 0) {
        child.first = static_cast<std::uint32_t>(~from.child[c]);
        child.count = static_cast<std::uint32_t>(from.count[c]);
        if (child.count > 0) child.box = child_box(from, c);
      }
      nodes.push_back(child);
      origins.push_back(from.child[c]);
    }
  }
  std::vector<std::uint32_t> items(primitives.size());
  std::iota(items.begin(), items.end(), 0u);
  tree.wide = fold(std::move(nodes), items, primitives, std::move(stop));
  tree.figures.bytes += tree.wide.bytes();
}

}  // namespace tessera::render
