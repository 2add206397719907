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
  Folder(BigArray<BinaryNode> nodes, std::span<const std::uint32_t> items,
         const std::vector<Primitive>& primitives, std::stop_token stop)
      : nodes_(std::move(nodes)),
        in_order_(items.empty()),
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
    if (in_order_) {
      tree.items.reserve(primitives_.size());
      tree.rows.reserve(9 * primitives_.size());
    }
    fold_below(nodes_[0], tree);
    return tree;
  }

 private:
  bool are_triangles(const BinaryNode& leaf) const {
    for (std::uint32_t i = leaf.first; i < leaf.first + leaf.count; ++i) {
      if (primitives_[item(i)].kind != PrimitiveKind::kTriangle) return false;
    }
    return true;
  }

  std::uint32_t item(std::uint32_t i) const { return in_order_ ? i : items_[i]; }

  /// Its box, from those of its children; where these are leaves with few triangles together, it is one.
  void prepare(BinaryNode& node) {
    if (node.child[0] < 0) return;
    const BinaryNode* const children[2] = {&nodes_[static_cast<std::size_t>(node.child[0])],
                                           &nodes_[static_cast<std::size_t>(node.child[1])]};
    bool few = true;
    for (const BinaryNode* const child : children) {
      node.box.add(child->box);
      few = few && child->child[0] < 0 && child->count <= kFew;
    }
    if (!few) return;
    if (in_order_) {
      const BinaryNode& first = *children[children[0]->count == 0];
      const std::uint32_t count = children[0]->count + children[1]->count;
      const BinaryNode all{.first = first.first, .count = count};
      if (count > kFew || !are_triangles(all)) return;
      node.child[0] = node.child[1] = -1;
      node.first = all.first, node.count = count;
      return;
    }
    std::array<std::uint32_t, 2 * kFew> together;
    std::size_t n = 0;
    for (const BinaryNode* const child : children) {
      if (!are_triangles(*child)) return;
      std::copy_n(items_.data() + child->first, child->count, together.data() + n);
      n += child->count;
    }
    const auto end = together.begin() + static_cast<std::ptrdiff_t>(n);
    std::sort(together.begin(), end);
    n = static_cast<std::size_t>(std::unique(together.begin(), end) - together.begin());
    if (n > kFew) return;
    node.child[0] = node.child[1] = -1;
    node.first = static_cast<std::uint32_t>(items_.size());
    node.count = static_cast<std::uint32_t>(n);
    items_.insert(items_.end(), together.data(), together.data() + n);
  }

  struct Children {
    std::array<const BinaryNode*, kChildren> nodes;
    std::array<double, kChildren> areas;  // of those that can be opened; -1 of others
    std::size_t count = 0;

    std::size_t size() const { return count; }
    const BinaryNode* operator[](std::size_t i) const { return nodes[i]; }
    void add(const BinaryNode& node) {
      nodes[count] = &node;
      areas[count++] = node.child[0] >= 0 ? node.box.area() : -1;
    }
    const BinaryNode& take(std::size_t i) {
      const BinaryNode& taken = *nodes[i];
      std::copy(nodes.begin() + i + 1, nodes.begin() + count, nodes.begin() + i);
      std::copy(areas.begin() + i + 1, areas.begin() + count, areas.begin() + i);
      --count;
      return taken;
    }
  };

  /// Children of the wide node that stands for `top`.
  Children children_of(const BinaryNode& top) const {
    Children children;
    children.add(top);
    while (children.size() < kChildren) {
      const auto end = children.areas.begin() + children.count;
      const auto largest =
          static_cast<std::size_t>(std::max_element(children.areas.begin(), end) - children.areas.begin());
      if (children[largest]->child[0] < 0) break;
      const BinaryNode& opened = children.take(largest);
      for (const std::int32_t c : opened.child) {
        const BinaryNode& child = nodes_[static_cast<std::size_t>(c)];
        if (!child.box.empty()) children.add(child);
      }
    }
    return children;
  }

  std::int32_t fold_below(const BinaryNode& top, WideTree& tree) {
    throw_if_stopped(stop_);
    const Children children = children_of(top);
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
    const std::size_t row = tree.rows.size();
    tree.rows.resize(row + 9 * leaf.count);
    float* const rows = tree.rows.data() + row;
    for (std::uint32_t column = 0; column < leaf.count; ++column) {
      const std::uint32_t at = item(leaf.first + column);
      tree.items.push_back(at);
      const float* const corners = &primitives_[at].corners[0][0];
      for (std::uint32_t k = 0; k < 9; ++k) rows[k * leaf.count + column] = corners[k];
    }
  }

  BigArray<BinaryNode> nodes_;
  const bool in_order_;
  std::vector<std::uint32_t> items_;  // none where those of leaves are in order
  const std::vector<Primitive>& primitives_;
  const std::stop_token stop_;
};

}  // namespace

WideTree fold(BigArray<BinaryNode> nodes, std::span<const std::uint32_t> items,
              const std::vector<Primitive>& primitives, std::stop_token stop) {
  constexpr std::size_t kMostItems = std::size_t{1} << 30;  // a child's number has 31 bits
  if (std::max(items.size(), primitives.size()) > kMostItems) return {};
  return Folder(std::move(nodes), items, primitives, std::move(stop)).fold();
}

}  // namespace tessera::render
