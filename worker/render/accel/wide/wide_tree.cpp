#include "render/accel/wide/wide_tree.h"

#include <algorithm>
#include <array>

#include "render/core/stopped.h"

namespace tessera::render {

namespace {

constexpr std::size_t kChildren = 16;
/// Subtrees with no more triangles than that are leaves.
constexpr std::size_t kFew = 16;

class Folder {
 public:
  Folder(std::vector<BinaryNode> nodes, std::span<const std::uint32_t> items,
         const std::vector<Primitive>& primitives, std::stop_token stop)
      : nodes_(std::move(nodes)),
        items_(items.begin(), items.end()),
        primitives_(primitives),
        stop_(std::move(stop)) {}

  WideTree fold() {
    for (std::size_t i = nodes_.size(); i-- > 0;) {
      throw_if_stopped(stop_, i);
      prepare(nodes_[i]);
    }
    WideTree tree;
    if (nodes_.empty() || nodes_[0].box.empty()) return tree;
    fold_below(nodes_[0], tree);
    return tree;
  }

 private:
  bool are_triangles(const BinaryNode& leaf) const {
    const std::uint32_t* const first = items_.data() + leaf.first;
    return std::all_of(first, first + leaf.count,
                       [this](std::uint32_t i) { return primitives_[i].kind == PrimitiveKind::kTriangle; });
  }

  /// Its box, from those of its children; where these are leaves with few triangles together, it is one.
  void prepare(BinaryNode& node) {
    if (node.child[0] < 0) return;
    std::array<std::uint32_t, 2 * kFew> together;
    std::size_t n = 0;
    bool few = true;
    for (const std::int32_t c : node.child) {
      const BinaryNode& child = nodes_[static_cast<std::size_t>(c)];
      node.box.add(child.box);
      few = few && child.child[0] < 0 && child.count <= kFew && (child.count == 0 || are_triangles(child));
      if (!few) continue;
      std::copy_n(items_.data() + child.first, child.count, together.data() + n);
      n += child.count;
    }
    if (!few) return;
    const auto end = together.begin() + static_cast<std::ptrdiff_t>(n);
    std::sort(together.begin(), end);
    n = static_cast<std::size_t>(std::unique(together.begin(), end) - together.begin());
    if (n > kFew) return;
    node.child[0] = node.child[1] = -1;
    node.first = static_cast<std::uint32_t>(items_.size());
    node.count = static_cast<std::uint32_t>(n);
    items_.insert(items_.end(), together.data(), together.data() + n);
  }

  /// Children of the wide node that stands for `top`.
  std::vector<const BinaryNode*> children_of(const BinaryNode& top) const {
    std::vector<const BinaryNode*> children{&top};
    while (children.size() < kChildren) {
      const auto area_to_open = [](const BinaryNode* n) { return n->child[0] >= 0 ? n->box.area() : -1; };
      const auto largest = std::ranges::max_element(children, {}, area_to_open);
      if ((*largest)->child[0] < 0) break;
      const BinaryNode& opened = **largest;
      children.erase(largest);
      for (const std::int32_t c : opened.child) {
        const BinaryNode& child = nodes_[static_cast<std::size_t>(c)];
        if (!child.box.empty()) children.push_back(&child);
      }
    }
    return children;
  }

  std::int32_t fold_below(const BinaryNode& top, WideTree& tree) {
    throw_if_stopped(stop_);
    const std::vector<const BinaryNode*> children = children_of(top);
    const std::size_t self = tree.nodes.size();
    tree.nodes.emplace_back();
    for (std::size_t i = 0; i < kChildren; ++i) {
      const Box box = i < children.size() ? children[i]->box : Box{};
      WideNode& node = tree.nodes[self];
      for (int k = 0; k < 3; ++k) node.low[k][i] = box.low[k], node.high[k][i] = box.high[k];
      node.child[i] = ~0, node.count[i] = 0;
      if (i < children.size() && children[i]->child[0] < 0) add_leaf(*children[i], i, node, tree);
    }
    for (std::size_t i = 0; i < children.size(); ++i) {
      if (children[i]->child[0] < 0) continue;
      const std::int32_t below = fold_below(*children[i], tree);
      tree.nodes[self].child[i] = below;
    }
    return static_cast<std::int32_t>(self);
  }

  void add_leaf(const BinaryNode& leaf, std::size_t i, WideNode& node, WideTree& tree) const {
    const auto count = static_cast<std::int32_t>(leaf.count);
    node.child[i] = ~static_cast<std::int32_t>(tree.items.size());
    node.count[i] = are_triangles(leaf) ? count : -count;
    const auto first = items_.begin() + leaf.first;
    tree.items.insert(tree.items.end(), first, first + count);
    for (int row = 0; row < 9; ++row) {
      for (auto item = first; item != first + count; ++item)
        tree.rows.push_back(primitives_[*item].corners[row / 3][row % 3]);
    }
  }

  std::vector<BinaryNode> nodes_;
  std::vector<std::uint32_t> items_;
  const std::vector<Primitive>& primitives_;
  const std::stop_token stop_;
};

}  // namespace

WideTree fold(std::vector<BinaryNode> nodes, std::span<const std::uint32_t> items,
              const std::vector<Primitive>& primitives, std::stop_token stop) {
  constexpr std::size_t kMostItems = std::size_t{1} << 30;  // a child's number has 31 bits
  if (items.size() > kMostItems) return {};
  return Folder(std::move(nodes), items, primitives, std::move(stop)).fold();
}

}  // namespace tessera::render
