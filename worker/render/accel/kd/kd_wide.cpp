// A kd-tree as fold() takes it: cells with something in them, no larger than the parts of what is in them.
#include "render/accel/kd/kd_tree.h"
#include "render/accel/structure/clip.h"
#include "render/core/stopped.h"

namespace tessera::render {

namespace {

class KdUnfolded {
 public:
  KdUnfolded(const KdTree& tree, const std::vector<Primitive>& primitives, const std::stop_token& stop)
      : tree_(tree), primitives_(primitives), stop_(stop) {}

  std::int32_t add(std::int32_t at, const Box& cell) {
    throw_if_stopped(stop_);
    const auto self = static_cast<std::int32_t>(nodes.size());
    nodes.emplace_back();
    if (at < 0) {
      BinaryNode& leaf = nodes.back();
      const auto items = tree_.items_of(at);
      leaf.first = static_cast<std::uint32_t>(items.data() - tree_.items.data());
      leaf.count = static_cast<std::uint32_t>(items.size());
      for (const std::uint32_t i : items) {
        const Box part = part_within(primitives_[i], cell);
        // A primitive that is in the cell by a rounding of the builder's alone stays in it.
        leaf.box.add(part.empty() ? box_of(primitives_[i]).within(cell) : part);
      }
      return self;
    }
    const KdNode& node = tree_.nodes[static_cast<std::size_t>(at)];
    Box cells[2] = {cell, cell};
    cells[0].high[node.axis] = cells[1].low[node.axis] = node.split;
    for (int c = 0; c < 2; ++c) {
      const std::int32_t child = add(node.child[c], cells[c]);
      nodes[static_cast<std::size_t>(self)].child[c] = child;
    }
    return self;
  }

  BigArray<BinaryNode> nodes;

 private:
  const KdTree& tree_;
  const std::vector<Primitive>& primitives_;
  const std::stop_token& stop_;
};

}  // namespace

void widen(const std::vector<Primitive>& primitives, KdTree& tree, std::stop_token stop) {
  KdUnfolded unfolded(tree, primitives, stop);
  unfolded.add(tree.root, tree.box);
  tree.wide = fold(std::move(unfolded.nodes), tree.items, primitives, stop);
}

}  // namespace tessera::render
