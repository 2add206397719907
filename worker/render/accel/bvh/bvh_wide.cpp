// Folds a binary tree into one of sixteen children a node.
#include "render/accel/bvh/bvh.h"

namespace tessera::render {

namespace {

constexpr int kWideChildren = 16;

struct Folded {
  const BvhNode* parent;
  int side;

  std::int32_t child() const { return parent->child[side]; }
  std::int32_t count() const { return parent->count[side]; }
  Box box() const {
    Box box;
    for (int k = 0; k < 3; ++k)
      box.low[k] = parent->planes[k][side], box.high[k] = parent->planes[k][2 + side];
    return box;
  }
};

/// The node that stands for binary node `at` and those below that it takes in; returns its number.
std::int32_t fold(Bvh& tree, std::int32_t at) {
  const BvhNode& top = tree.nodes[static_cast<std::size_t>(at)];
  std::vector<Folded> children{{&top, 0}, {&top, 1}};
  while (children.size() < kWideChildren) {
    const auto area_to_open = [](const Folded& f) { return f.child() >= 0 ? f.box().area() : -1; };
    const auto largest = std::ranges::max_element(children, {}, area_to_open);
    if (largest->child() < 0) break;
    const BvhNode& opened = tree.nodes[static_cast<std::size_t>(largest->child())];
    *largest = {&opened, 0};
    children.push_back({&opened, 1});
  }
  const auto self = static_cast<std::int32_t>(tree.wide.size());
  WideBvhNode node;
  for (int i = 0; i < kWideChildren; ++i) {
    const bool there = static_cast<std::size_t>(i) < children.size();
    const Box box = there ? children[static_cast<std::size_t>(i)].box() : Box{};
    for (int k = 0; k < 3; ++k) node.low[k][i] = box.low[k], node.high[k][i] = box.high[k];
    node.child[i] = there ? children[static_cast<std::size_t>(i)].child() : ~0;
    node.count[i] = there ? children[static_cast<std::size_t>(i)].count() : 0;
  }
  tree.wide.push_back(node);
  for (std::size_t i = 0; i < children.size(); ++i) {
    if (children[i].child() >= 0) {
      const std::int32_t below = fold(tree, children[i].child());
      tree.wide[static_cast<std::size_t>(self)].child[i] = below;
    }
  }
  return self;
}

}  // namespace

void widen(Bvh& tree) {
  if (tree.nodes.empty()) return;
  fold(tree, 0);
  tree.figures.bytes += tree.wide.size() * sizeof(WideBvhNode);
}

}  // namespace tessera::render
