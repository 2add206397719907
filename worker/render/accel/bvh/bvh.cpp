#include "render/accel/bvh/bvh.h"

#include <mutex>

#include "render/accel/structure/forks.h"
#include "render/core/stopped.h"

namespace tessera::render {

namespace {

/// A subtree, as its parent refers to it.
struct BvhChild {
  Box box;
  std::int32_t child, count;
};

class BvhBuilder {
 public:
  BvhBuilder(BvhRule rule, std::span<const Primitive> primitives, std::span<BvhRef> refs, int threads,
             std::stop_token stop)
      : rule_(rule), refs_(refs), forks_(threads), stop_(std::move(stop)), primitives_(primitives) {}

  /// Numbers of triangles that stand where another does, and need not be in the tree.
  const std::vector<std::uint32_t>& twins() const { return twins_; }

  /// Grows the subtree of refs [first, first + n), with its nodes at the end of `nodes`.
  BvhChild grow(std::size_t first, std::size_t n, int depth, std::vector<BvhNode>& nodes) {
    throw_if_stopped(stop_);
    const std::span<BvhRef> refs = refs_.subspan(first, n);
    if (rule_ == BvhRule::kSah && n <= kSweptSize) {
      SweptSet set(refs);
      return grow_swept(set, first, 0, n, depth, nodes);
    }
    WideBox boxes;
    Box centres;
    for (const BvhRef& ref : refs) {
      boxes.add(ref.box);
      const float centre[3] = {ref.box.centre(0), ref.box.centre(1), ref.box.centre(2)};
      centres.add(centre);
    }
    const Box box = boxes.box();
    const std::size_t left = part(refs, box, centres, depth);
    if (left == 0) return {box, ~static_cast<std::int32_t>(first), static_cast<std::int32_t>(n)};
    const std::size_t self = nodes.size();
    nodes.emplace_back();
    BvhChild children[2];
    if (n < kForkSize) {
      children[0] = grow(first, left, depth + 1, nodes);
      children[1] = grow(first + left, n - left, depth + 1, nodes);
    } else {
      std::vector<BvhNode> right;
      forks_.both([&] { children[0] = grow(first, left, depth + 1, nodes); },
                  [&] { children[1] = grow(first + left, n - left, depth + 1, right); });
      append(right, nodes, children[1]);
    }
    set(children, nodes[self]);
    return {box, static_cast<std::int32_t>(self), 0};
  }

  static void set(const BvhChild (&children)[2], BvhNode& node) {
    for (int c = 0; c < 2; ++c) {
      node.child[c] = children[c].child, node.count[c] = children[c].count;
      for (int k = 0; k < 3; ++k)
        node.planes[k][c] = children[c].box.low[k], node.planes[k][2 + c] = children[c].box.high[k];
    }
  }

  /// Grows the subtree of `n` refs from `at` on of the set that begins at `first`.
  BvhChild grow_swept(SweptSet& set, std::size_t first, std::size_t at, std::size_t n, int depth,
                      std::vector<BvhNode>& nodes) {
    const Box box = set.box_of(at, n);
    std::size_t left = 0;
    if (depth > kDeepest) {
      left = n <= kMedianLeaf ? 0 : set.halve(at, n);
    } else if (n > 1) {
      left = set.part(at, n, box);
    }
    if (left == 0) {
      set.put_back(at, n);
      return {box, ~static_cast<std::int32_t>(first + at), static_cast<std::int32_t>(n)};
    }
    const std::size_t self = nodes.size();
    nodes.emplace_back();
    const BvhChild children[2] = {grow_swept(set, first, at, left, depth + 1, nodes),
                                  grow_swept(set, first, at + left, n - left, depth + 1, nodes)};
    BvhBuilder::set(children, nodes[self]);
    return {box, static_cast<std::int32_t>(self), 0};
  }

 private:
  // Halving from there on ends before the walk's stack does, whatever the primitives are.
  static constexpr int kDeepest = kBvhDepth - 34;

  std::size_t part(std::span<BvhRef> refs, const Box& box, const Box& centres, int depth) {
    if (refs.size() <= 1) return 0;
    if (refs.size() > kSweptSize && centres.extent(centres.longest_axis()) == 0) note_twins(refs);
    if (rule_ == BvhRule::kMedian || depth > kDeepest)
      return refs.size() <= kMedianLeaf ? 0 : part_at_median(refs, centres);
    return part_by_sah(refs, box, centres);
  }

  /// Marks all but one of the triangles with the same corners: a ray meets the one with the least numbers,
  /// whatever order it sees them in, so that the others can be left out, unless it may pass through.
  void note_twins(std::span<const BvhRef> refs) {
    std::vector<const Primitive*> triangles;
    for (const BvhRef& ref : refs) {
      const Primitive& p = primitives_[ref.index];
      if (p.kind == PrimitiveKind::kTriangle && p.has_alpha == 0) triangles.push_back(&p);
    }
    const auto corners = [](const Primitive* p) { return std::span(&p->corners[0][0], 9); };
    std::ranges::sort(triangles, [&](const Primitive* a, const Primitive* b) {
      const int order = std::memcmp(a->corners, b->corners, sizeof(a->corners));
      return order != 0 ? order < 0 : std::pair(a->shape, a->number) < std::pair(b->shape, b->number);
    });
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 1; i < triangles.size(); ++i) {
      if (std::ranges::equal(corners(triangles[i - 1]), corners(triangles[i])))
        twins_.push_back(static_cast<std::uint32_t>(triangles[i] - primitives_.data()));
    }
  }

  static void append(const std::vector<BvhNode>& from, std::vector<BvhNode>& to, BvhChild& root) {
    const auto base = static_cast<std::int32_t>(to.size());
    for (BvhNode node : from) {
      for (std::int32_t& child : node.child) child += child >= 0 ? base : 0;
      to.push_back(node);
    }
    if (root.child >= 0) root.child += base;
  }

  const BvhRule rule_;
  const std::span<BvhRef> refs_;
  Forks forks_;
  const std::stop_token stop_;
  const std::span<const Primitive> primitives_;
  std::mutex mutex_;
  std::vector<std::uint32_t> twins_;
};

/// Fills in what is found along the tree; `area` is that of the root.
void measure(const Bvh& tree, std::int32_t node, std::int32_t depth, double area, StructureFigures& f) {
  const BvhNode& at = tree.nodes[static_cast<std::size_t>(node)];
  f.depth = std::max(f.depth, depth + 1);
  for (int c = 0; c < 2; ++c) {
    const double share = area > 0 ? child_box(at, c).area() / area : 1;
    if (at.child[c] >= 0) {
      f.sah_cost += kStepCost * share;
      measure(tree, at.child[c], depth + 1, area, f);
    } else if (at.count[c] > 0) {
      ++f.leaves;
      f.sah_cost += kTestCost * share * at.count[c];
    }
  }
}

}  // namespace

Box child_box(const BvhNode& node, int c) {
  Box box;
  for (int k = 0; k < 3; ++k) box.low[k] = node.planes[k][c], box.high[k] = node.planes[k][2 + c];
  return box;
}

Bvh build_bvh(BvhRule rule, std::vector<Primitive>& primitives, int threads, std::stop_token stop) {
  Bvh tree;
  if (primitives.empty()) return tree;
  std::vector<BvhRef> refs(primitives.size());
  for (std::size_t i = 0; i < refs.size(); ++i)
    refs[i] = {box_of(primitives[i]), static_cast<std::uint32_t>(i)};
  BvhBuilder builder(rule, primitives, refs, threads, stop);
  const BvhChild root = builder.grow(0, refs.size(), 0, tree.nodes);
  if (!builder.twins().empty()) {
    for (const std::uint32_t twin : builder.twins()) primitives[twin].number = -1;
    std::erase_if(primitives, [](const Primitive& p) { return p.number < 0; });
    return build_bvh(rule, primitives, threads, std::move(stop));
  }
  // A lone leaf hangs on a node with nothing on its other side.
  if (root.child < 0) BvhBuilder::set({root, {root.box, ~0, 0}}, tree.nodes.emplace_back());
  std::vector<Primitive> ordered(primitives.size());
  for (std::size_t i = 0; i < refs.size(); ++i) ordered[i] = primitives[refs[i].index];
  primitives.swap(ordered);

  StructureFigures& f = tree.figures;
  f.nodes = tree.nodes.size();
  f.references = primitives.size();
  f.bytes = tree.nodes.size() * sizeof(BvhNode);
  f.sah_cost = kStepCost;
  measure(tree, 0, 0, root.box.area(), f);
  return tree;
}

}  // namespace tessera::render
