// A binary tree of boxes, folded: sixteen children a node, and leaves whose triangles stand in rows. How BVH
// and kd-tree are searched unless they are asked to be walked as they are read.
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "render/accel/structure/primitive.h"
#include "render/core/big_array.h"

namespace tessera::render {

/// Sixteen children, whose boxes are tested at once: some steps of the binary tree in one [Wald2008].
struct alignas(64) WideNode {
  float low[3][16], high[3][16];  // an axis each; a child that is not there has its lower end above the upper
  std::int32_t child[16];         // a node; or ~ the first item of a leaf
  std::int32_t count[16];         // number of a leaf's items; negative where not all of them are triangles
};

struct WideTree {
  BigArray<WideNode> nodes;       // the root first; none: the tree was not folded, or is empty
  BigArray<std::uint32_t> items;  // indices of primitives, leaf by leaf
  /// Nine rows for each leaf, as long as it has items: x, y, z of the first corners, of the second, of the
  /// third. A load of sixteen may begin at any element.
  BigArray<float> rows;

  std::size_t bytes() const {
    return nodes.size() * sizeof(WideNode) + items.size() * sizeof(items[0]) + rows.size() * sizeof(rows[0]);
  }
};

/// A node of what is folded. Parents stand before their children, the root first.
struct BinaryNode {
  Box box{};                           // set in leaves; that of others follows
  std::int32_t child[2] = {-1, -1};    // none of both: a leaf
  std::uint32_t first = 0, count = 0;  // a leaf's range of items
};

/// Opens the largest children of a node until it has sixteen. What holds few triangles becomes a leaf, in
/// which each stands once. Without `items`, those of leaves are the primitives themselves, in their order. Of
/// more than 2^30 items nothing is made: the tree is walked as it is read.
WideTree fold(BigArray<BinaryNode> nodes, std::span<const std::uint32_t> items,
              const std::vector<Primitive>& primitives, std::stop_token stop = {});

}  // namespace tessera::render
