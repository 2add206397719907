// Builders of hierarchies come to an end with primitives that nothing can part.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "render/accel/bvh/bvh.h"
#include "render/accel/sphere_tree/sphere_tree.h"

namespace tessera::render {
namespace {

/// `n` triangles with the same corners, numbered from the last to the first.
std::vector<Primitive> twins(int n) {
  std::vector<Primitive> list(static_cast<std::size_t>(n));
  constexpr float kCorners[3][3] = {{0, 0, 0}, {1, 0, 0.5f}, {0, 1, 0.25f}};
  for (int i = 0; i < n; ++i) {
    Primitive& triangle = list[static_cast<std::size_t>(i)];
    std::copy_n(&kCorners[0][0], 9, &triangle.corners[0][0]);
    triangle.number = n - 1 - i;
  }
  return list;
}

TEST(BvhBuild, KeepsTheFirstOfIdenticalTriangles) {
  for (const BvhRule rule : {BvhRule::kMedian, BvhRule::kSah}) {
    std::vector<Primitive> list = twins(1000);
    const Bvh tree = build_bvh(rule, list, 2);
    ASSERT_EQ(list.size(), 1);
    EXPECT_EQ(list[0].number, 0);
    EXPECT_EQ(tree.figures.references, 1);
  }
  std::vector<Primitive> list = twins(1000);
  EXPECT_EQ(build_sphere_tree(list, 1).figures.references, 1);
  EXPECT_EQ(list.size(), 1);
}

/// A ray may go through the one and be stopped by the other.
TEST(BvhBuild, KeepsAllOfThoseWithHoles) {
  std::vector<Primitive> list = twins(1000);
  for (int i = 0; i < 500; ++i) list[static_cast<std::size_t>(2 * i)].has_alpha = 1;
  build_bvh(BvhRule::kSah, list, 1);
  EXPECT_EQ(list.size(), 501);
  EXPECT_EQ(std::ranges::count(list, 1, &Primitive::has_alpha), 500);
}

/// Each primitive is in one leaf, whichever way the sets above it were parted.
TEST(BvhBuild, HasEveryPrimitiveOnce) {
  std::vector<Primitive> list;
  for (int i = 0; i < 5000; ++i) {
    Primitive triangle{};
    for (int c = 0; c < 9; ++c)
      triangle.corners[c / 3][c % 3] = static_cast<float>((i * 7919 + c * c * 104729) % 9973) + c;
    triangle.number = i;
    list.push_back(triangle);
  }
  const Bvh tree = build_bvh(BvhRule::kSah, list, 3);
  std::vector<int> seen(list.size());
  for (const BvhNode& node : tree.nodes) {
    for (int c = 0; c < 2; ++c) {
      if (node.child[c] >= 0) continue;
      for (int i = 0; i < node.count[c]; ++i) {
        const auto at = static_cast<std::size_t>(~node.child[c] + i);
        ++seen[static_cast<std::size_t>(list[at].number)];
        const Box box = box_of(list[at]), leaf = child_box(node, c);
        for (int k = 0; k < 3; ++k)
          ASSERT_TRUE(leaf.low[k] <= box.low[k] && box.high[k] <= leaf.high[k]) << at;
      }
    }
  }
  EXPECT_EQ(std::ranges::count(seen, 1), 5000);
}

}  // namespace
}  // namespace tessera::render
