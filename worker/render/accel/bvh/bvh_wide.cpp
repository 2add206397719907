// A BVH as fold() takes it.
#include "render/accel/bvh/bvh.h"
#include "render/core/stopped.h"

namespace tessera::render {

void widen(const std::vector<Primitive>& primitives, Bvh& tree, std::stop_token stop) {
  // Nodes as they are, children after their parents; leaves, one more, behind them.
  BigArray<BinaryNode> nodes(tree.nodes.empty() ? 0 : 2 * tree.nodes.size() + 1);
  std::size_t leaf = tree.nodes.size();
  for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
    throw_if_stopped(stop, i);
    const BvhNode& from = tree.nodes[i];
    for (int c = 0; c < 2; ++c) {
      nodes[i].child[c] = from.child[c];
      if (from.child[c] >= 0) continue;
      nodes[i].child[c] = static_cast<std::int32_t>(leaf);
      BinaryNode& child = nodes[leaf++];
      child.first = static_cast<std::uint32_t>(~from.child[c]);
      child.count = static_cast<std::uint32_t>(from.count[c]);
      if (child.count > 0) child.box = child_box(from, c);
    }
  }
  tree.wide = fold(std::move(nodes), {}, primitives, std::move(stop));
  tree.figures.bytes += tree.wide.bytes();
}

}  // namespace tessera::render
