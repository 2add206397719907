#include "render/accel/sphere_tree/sphere_tree.h"

#include "render/accel/bvh/bvh.h"
#include "render/core/stopped.h"

namespace tessera::render {

namespace {

double squared_distance(const float* a, const float* b) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += (double{a[k]} - b[k]) * (double{a[k]} - b[k]);
  return sum;
}

/// Farthest point of a primitive from `centre`, squared.
double farthest(const Primitive& primitive, const float* centre) {
  double most = 0;
  if (primitive.kind == PrimitiveKind::kTriangle) {
    for (const auto& corner : primitive.corners) most = std::max(most, squared_distance(corner, centre));
    return most;
  }
  for (int k = 0; k < 3; ++k) {
    const double d = std::max(std::abs(double{primitive.corners[0][k]} - centre[k]),
                              std::abs(double{primitive.corners[1][k]} - centre[k]));
    most += d * d;
  }
  return most;
}

class SphereTreeBuilder {
 public:
  SphereTreeBuilder(const Bvh& boxes, const std::vector<Primitive>& primitives, SphereTree& tree,
                    std::stop_token stop)
      : boxes_(boxes), primitives_(primitives), tree_(tree), stop_(std::move(stop)) {}

  /// The spheres of [first, first + n), parted as the tree of boxes parts them; `node` of that is negative
  /// for a leaf.
  std::int32_t grow(std::int32_t node, std::size_t first, std::size_t n, std::int32_t depth) {
    throw_if_stopped(stop_);
    const auto self = static_cast<std::int32_t>(tree_.nodes.size());
    tree_.nodes.push_back(around(first, n));
    StructureFigures& f = tree_.figures;
    f.depth = std::max(f.depth, depth);
    if (node < 0) {
      ++f.leaves;
      tree_.nodes.back().child[0] = static_cast<std::int32_t>(first);
      tree_.nodes.back().child[1] = ~static_cast<std::int32_t>(n);
      return self;
    }
    ++f.nodes;
    const BvhNode& box = boxes_.nodes[static_cast<std::size_t>(node)];
    const std::size_t left = primitives_below(box, 0);
    const std::int32_t a = grow(box.child[0], first, left, depth + 1);
    const std::int32_t b = grow(box.child[1], first + left, n - left, depth + 1);
    SphereNode& grown = tree_.nodes[static_cast<std::size_t>(self)];
    grown.child[0] = a, grown.child[1] = b;
    return self;
  }

 private:
  /// About the centre of the primitives' box, as large as they need.
  SphereNode around(std::size_t first, std::size_t n) const {
    if (n == 0) return {.radius = -1};  // the empty side of a tree that is one leaf
    Box box;
    for (std::size_t i = 0; i < n; ++i) box.add(box_of(primitives_[first + i]));
    SphereNode node;
    for (int k = 0; k < 3; ++k) node.centre[k] = box.centre(k);
    double most = 0;
    for (std::size_t i = 0; i < n; ++i) most = std::max(most, farthest(primitives_[first + i], node.centre));
    node.radius = std::nextafter(static_cast<float>(std::sqrt(most)), Box::kInfinity);
    return node;
  }

  std::size_t primitives_below(const BvhNode& node, int c) const {
    if (node.child[c] < 0) return static_cast<std::size_t>(node.count[c]);
    const BvhNode& child = boxes_.nodes[static_cast<std::size_t>(node.child[c])];
    return primitives_below(child, 0) + primitives_below(child, 1);
  }

  const Bvh& boxes_;
  const std::vector<Primitive>& primitives_;
  SphereTree& tree_;
  const std::stop_token stop_;
};

}  // namespace

SphereTree build_sphere_tree(std::vector<Primitive>& primitives, int threads, std::stop_token stop) {
  SphereTree tree;
  if (primitives.empty()) return tree;
  const Bvh boxes = build_bvh(BvhRule::kMedian, primitives, threads, stop);
  tree.nodes.reserve(2 * boxes.nodes.size() + 1);
  SphereTreeBuilder(boxes, primitives, tree, std::move(stop)).grow(0, 0, primitives.size(), 0);
  tree.figures.references = primitives.size();
  tree.figures.bytes = tree.nodes.size() * sizeof(SphereNode);
  return tree;
}

absl::Status build_tree(const StructureOptions& options, std::vector<Primitive>& primitives,
                        SphereTree& tree) {
  tree = build_sphere_tree(primitives, options.threads, options.stop);
  return absl::OkStatus();
}

}  // namespace tessera::render
