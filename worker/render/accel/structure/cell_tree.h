// Trees whose leaves are cells of space: kd-tree, octree, BSP. A primitive may lie in several cells, so
// leaves have lists of their own.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/accel/structure/figures.h"
#include "render/accel/structure/primitive.h"

namespace tessera::render {

/// `Node` has an array `child`: 0 and above are nodes, below are leaves: ~child. Nodes stand depth first.
template <class Node>
struct CellTree {
  struct Leaf {
    std::uint32_t first = 0, count = 0;  // a range of `items`
  };
  std::vector<Node> nodes;
  std::vector<Leaf> leaves;
  std::vector<std::uint32_t> items;  // indices of primitives
  Box box;
  std::int32_t root = -1;

  std::span<const std::uint32_t> items_of(std::int32_t leaf_child) const {
    const Leaf& leaf = leaves[static_cast<std::size_t>(~leaf_child)];
    return {items.data() + leaf.first, leaf.count};
  }

  /// Adds a leaf; returns how a node refers to it. `index_of` turns an element into a primitive's index.
  template <class Refs, class IndexOf>
  std::int32_t add_leaf(const Refs& refs, IndexOf&& index_of) {
    leaves.push_back({static_cast<std::uint32_t>(items.size()), static_cast<std::uint32_t>(refs.size())});
    for (const auto& ref : refs) items.push_back(index_of(ref));
    return ~static_cast<std::int32_t>(leaves.size() - 1);
  }

  /// Adds all of another; returns how a node refers to its root, which it knew as `other_root`.
  std::int32_t append(const CellTree& other, std::int32_t other_root) {
    const auto node_base = static_cast<std::int32_t>(nodes.size());
    const auto leaf_base = static_cast<std::int32_t>(leaves.size());
    const auto item_base = static_cast<std::uint32_t>(items.size());
    const auto moved = [&](std::int32_t child) { return child >= 0 ? child + node_base : child - leaf_base; };
    for (Node node : other.nodes) {
      for (std::int32_t& child : node.child) child = moved(child);
      nodes.push_back(node);
    }
    for (const Leaf& leaf : other.leaves) leaves.push_back({leaf.first + item_base, leaf.count});
    items.insert(items.end(), other.items.begin(), other.items.end());
    return moved(other_root);
  }

  StructureFigures figures() const {
    StructureFigures f;
    f.nodes = nodes.size();
    for (const Leaf& leaf : leaves) ++(leaf.count > 0 ? f.leaves : f.empty_leaves);
    f.references = items.size();
    f.bytes = nodes.size() * sizeof(Node) + leaves.size() * sizeof(Leaf) + items.size() * 4;
    if (root >= 0) f.depth = depth_below(root);
    return f;
  }

 private:
  std::int32_t depth_below(std::int32_t node) const {
    std::int32_t most = 0;
    for (const std::int32_t child : nodes[static_cast<std::size_t>(node)].child)
      most = std::max(most, child >= 0 ? depth_below(child) : 0);
    return most + 1;
  }
};

/// How many references from cells to primitives a tree over n primitives may have. It is shared out to
/// subtrees in proportion to what is in them, so that no thread decides for another; where a subtree has
/// spent its share it ends in a leaf.
inline double reference_budget(std::size_t n) { return 8.0 * static_cast<double>(n) + 1024; }

}  // namespace tessera::render
