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
  BvhChild grow(std::size_t first, std::size_t n, const BvhBounds& bounds, int depth,
                BigArray<BvhNode>& nodes) {
    throw_if_stopped(stop_);
    const std::span<BvhRef> refs = refs_.subspan(first, n);
    if (rule_ == BvhRule::kSah && n <= kSweptSize) {
      SweptSet set(refs);
      return grow_swept(set, bounds.box, first, 0, n, depth, nodes);
    }
    BvhBounds halves[2];
    const std::size_t left = part(refs, bounds, depth, halves);
    if (left == 0) return {bounds.box, ~static_cast<std::int32_t>(first), static_cast<std::int32_t>(n)};
    const std::size_t self = nodes.size();
    nodes.emplace_back();
    BvhChild children[2];
    const auto grow_left = [&] { children[0] = grow(first, left, halves[0], depth + 1, nodes); };
    const auto grow_right = [&](BigArray<BvhNode>& into) {
      children[1] = grow(first + left, n - left, halves[1], depth + 1, into);
    };
    if (n < kForkSize) {
      grow_left();
      grow_right(nodes);
    } else {
      BigArray<BvhNode> right;
      forks_.both(
          grow_left, [&] { grow_right(right); }, [&] { grow_right(nodes); });
      if (!right.empty()) append(right, nodes, children[1]);
    }
    set(children, nodes[self]);
    return {bounds.box, static_cast<std::int32_t>(self), 0};
  }

  static void set(const BvhChild (&children)[2], BvhNode& node) {
    for (int c = 0; c < 2; ++c) {
      node.child[c] = children[c].child, node.count[c] = children[c].count;
      for (int k = 0; k < 3; ++k)
        node.planes[k][c] = children[c].box.low[k], node.planes[k][2 + c] = children[c].box.high[k];
    }
  }

  /// Grows the subtree of `n` refs from `at` on, in `box`, of the set that begins at `first`.
  BvhChild grow_swept(SweptSet& set, const Box& box, std::size_t first, std::size_t at, std::size_t n,
                      int depth, BigArray<BvhNode>& nodes) {
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
    const Box boxes[2] = {set.box_of(at, left), set.box_of(at + left, n - left)};
    const BvhChild children[2] = {grow_swept(set, boxes[0], first, at, left, depth + 1, nodes),
                                  grow_swept(set, boxes[1], first, at + left, n - left, depth + 1, nodes)};
    BvhBuilder::set(children, nodes[self]);
    return {box, static_cast<std::int32_t>(self), 0};
  }

 private:
  // Halving from there on ends before the walk's stack does, whatever the primitives are.
  static constexpr int kDeepest = kBvhDepth - 34;

  std::size_t part(std::span<BvhRef> refs, const BvhBounds& bounds, int depth, BvhBounds (&halves)[2]) {
    if (refs.size() <= 1) return 0;
    const Box& centres = bounds.centres;
    if (refs.size() > kSweptSize && centres.extent(centres.longest_axis()) == 0) note_twins(refs);
    if (rule_ == BvhRule::kSah && depth <= kDeepest) return part_by_sah(refs, bounds, halves);
    if (refs.size() <= kMedianLeaf) return 0;
    const std::size_t left = part_at_median(refs, centres);
    halves[0] = bounds_of(refs.first(left)), halves[1] = bounds_of(refs.subspan(left));
    return left;
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

  static void append(const BigArray<BvhNode>& from, BigArray<BvhNode>& to, BvhChild& root) {
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

/// Brings primitive order[i] to place i, for all i; where they change places in a ring, one after the other.
void reorder(BigArray<std::uint32_t> order, std::vector<Primitive>& primitives, const std::stop_token& stop) {
  constexpr int kAhead = 16;  // steps along the ring: each begins with a miss of the cache
  for (std::uint32_t i = 0; i < order.size(); ++i) {
    if (order[i] == i) continue;
    const Primitive first = primitives[i];
    std::uint32_t to = i, ahead = i;
    for (int k = 0; k < kAhead; ++k) ahead = order[ahead];
    for (std::uint32_t from = order[to]; from != i; to = from, from = order[to]) {
      __builtin_prefetch(&primitives[ahead]);
      ahead = order[ahead];
      throw_if_stopped(stop, to);
      primitives[to] = primitives[from];
      order[to] = to;
    }
    primitives[to] = first;
    order[to] = to;
  }
}

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

BvhBounds bounds_of(std::span<const BvhRef> refs) {
  WideBounds bounds;
  for (const BvhRef& ref : refs) bounds.add(ref);
  return bounds.bounds();
}

Bvh build_bvh(BvhRule rule, std::vector<Primitive>& primitives, int threads, std::stop_token stop) {
  Bvh tree;
  if (primitives.empty()) return tree;
  BigArray<BvhRef> refs(primitives.size());
  for (std::size_t i = 0; i < refs.size(); ++i) {
    throw_if_stopped(stop, i);
    refs[i] = {box_of(primitives[i]), static_cast<std::uint32_t>(i)};
  }
  BvhBuilder builder(rule, primitives, refs, threads, stop);
  // Where there is memory for more, pages that nothing is written to are not taken.
  tree.nodes.reserve(refs.size());
  const BvhChild root = builder.grow(0, refs.size(), bounds_of(refs), 0, tree.nodes);
  if (!builder.twins().empty()) {
    for (const std::uint32_t twin : builder.twins()) primitives[twin].number = -1;
    std::erase_if(primitives, [](const Primitive& p) { return p.number < 0; });
    return build_bvh(rule, primitives, threads, std::move(stop));
  }
  // A lone leaf hangs on a node with nothing on its other side.
  if (root.child < 0) BvhBuilder::set({root, {root.box, ~0, 0}}, tree.nodes.emplace_back());
  BigArray<std::uint32_t> order(refs.size());
  for (std::size_t i = 0; i < refs.size(); ++i) order[i] = refs[i].index;
  refs = {};
  reorder(std::move(order), primitives, stop);

  StructureFigures& f = tree.figures;
  f.nodes = tree.nodes.size();
  f.references = primitives.size();
  f.bytes = tree.nodes.size() * sizeof(BvhNode);
  f.sah_cost = kStepCost;
  measure(tree, 0, 0, root.box.area(), f);
  return tree;
}

absl::Status build_tree(const StructureOptions& options, std::vector<Primitive>& primitives, Bvh& tree,
                        BvhRule rule) {
  tree = build_bvh(rule, primitives, options.threads, options.stop);
  if (!options.wide) return absl::OkStatus();
  widen(primitives, tree, options.stop);
  if (tree.wide.nodes.empty()) return absl::OkStatus();
  // The folded tree is walked alone.
  tree.figures.bytes -= tree.nodes.size() * sizeof(BvhNode);
  tree.nodes = {};
  return absl::OkStatus();
}

}  // namespace tessera::render
