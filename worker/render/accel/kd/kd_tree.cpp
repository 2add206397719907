#include "render/accel/kd/kd_tree.h"

#include <array>

#include "render/accel/structure/clip.h"
#include "render/core/stopped.h"

namespace tessera::render {

namespace {

constexpr std::size_t kSmallLeaf = 2;

class KdBuilder {
 public:
  KdBuilder(KdRule rule, const std::vector<Primitive>& primitives, int threads, std::stop_token stop)
      : rule_(rule),
        primitives_(primitives),
        deepest_(kd_depth(primitives.size())),
        forks_(threads),
        stop_(std::move(stop)) {}

  /// `bad` counts the splits on the way here that cost more than they brought: one may lead to better ones,
  /// but after three of them a branch ends [Pharr2016, sec. 4.4.2].
  std::int32_t grow(std::vector<KdRef> refs, const Box& cell, int depth, int bad, double budget,
                    KdTree& tree) {
    constexpr int kMostBad = 3;
    throw_if_stopped(stop_);
    if (refs.size() <= kSmallLeaf || depth >= deepest_) return leaf(refs, tree);
    const KdSplit split = rule_ == KdRule::kMedian ? split_at_median(refs, cell, depth, stop_)
                                                   : split_by_sah(refs, cell, stop_);
    if (split.axis < 0) return leaf(refs, tree);
    if (rule_ == KdRule::kSah) {
      const double as_leaf = kTestCost * static_cast<double>(refs.size());
      bad += split.cost > as_leaf;
      constexpr std::size_t kFew = 16;
      if (bad >= kMostBad || (split.cost > 4 * as_leaf && refs.size() < kFew)) return leaf(refs, tree);
    }
    Box cells[2] = {cell, cell};
    cells[0].high[split.axis] = cells[1].low[split.axis] = split.place;
    std::vector<KdRef> parts[2];
    part(refs, split, cells, parts);
    const auto below = static_cast<double>(parts[0].size()),
               both = below + static_cast<double>(parts[1].size());
    const bool parted = parts[0].size() < refs.size() || parts[1].size() < refs.size();
    if (!parted || both > budget) return leaf(refs, tree);
    const bool fork = refs.size() >= kForkSize;
    refs = {};  // the way down holds one set a step
    return grow_both(split, cells, parts, {budget * below / both, budget * (both - below) / both}, depth, bad,
                     fork, tree);
  }

 private:
  std::int32_t grow_both(const KdSplit& split, const Box (&cells)[2], std::vector<KdRef> (&parts)[2],
                         const std::array<double, 2>& budgets, int depth, int bad, bool fork, KdTree& tree) {
    const auto self = static_cast<std::int32_t>(tree.nodes.size());
    tree.nodes.push_back({split.place, split.axis, {}});
    std::int32_t children[2];
    const auto grow_child = [&](int c, KdTree& into) {
      children[c] =
          grow(std::move(parts[c]), cells[c], depth + 1, bad, budgets[static_cast<std::size_t>(c)], into);
    };
    if (fork) {
      KdTree above;
      forks_.both([&] { grow_child(0, tree); }, [&] { grow_child(1, above); });
      children[1] = tree.append(above, children[1]);
    } else {
      grow_child(0, tree);
      grow_child(1, tree);
    }
    std::copy_n(children, 2, tree.nodes[static_cast<std::size_t>(self)].child);
    return self;
  }

  static std::int32_t leaf(const std::vector<KdRef>& refs, KdTree& tree) {
    return tree.add_leaf(refs, [](const KdRef& ref) { return ref.index; });
  }

  /// Perfect splits [Havran2000, sec. 4.3]: what crosses the plane goes to the sides that it reaches, with
  /// the bounds of its part there.
  void part(const std::vector<KdRef>& refs, const KdSplit& split, const Box (&cells)[2],
            std::vector<KdRef> (&parts)[2]) const {
    // Large ones at once, as copies of them would take long; pages that nothing is written to are not taken.
    if (refs.size() >= kForkSize) {
      for (std::vector<KdRef>& part : parts) part.reserve(refs.size());
    }
    for (const KdRef& ref : refs) {
      throw_if_stopped(stop_);
      const float low = ref.part.low[split.axis], high = ref.part.high[split.axis];
      const bool flat = low == high && low == split.place;
      const bool below = flat ? split.flat_below : low < split.place;
      const bool above = flat ? !split.flat_below : high > split.place;
      if (below != above) {
        parts[above ? 1 : 0].push_back(ref);
        continue;
      }
      for (int c = 0; c < 2; ++c) {
        const Box clipped = part_within(primitives_[ref.index], cells[c]);
        if (!clipped.empty()) parts[c].push_back({clipped, ref.index});
      }
    }
  }

  const KdRule rule_;
  const std::vector<Primitive>& primitives_;
  const int deepest_;
  Forks forks_;
  const std::stop_token stop_;
};

double cost_below(const KdTree& tree, std::int32_t child, const Box& cell) {
  if (child < 0) return kTestCost * cell.area() * static_cast<double>(tree.items_of(child).size());
  const KdNode& node = tree.nodes[static_cast<std::size_t>(child)];
  Box below = cell, above = cell;
  below.high[node.axis] = above.low[node.axis] = node.split;
  return kStepCost * cell.area() + cost_below(tree, node.child[0], below) +
         cost_below(tree, node.child[1], above);
}

}  // namespace

int kd_depth(std::size_t n) {
  return static_cast<int>(std::lround(8 + 1.3 * std::log2(static_cast<double>(std::max<std::size_t>(n, 1)))));
}

double kd_sah_cost(const KdTree& tree) {
  const double area = tree.box.area();
  return area > 0 ? cost_below(tree, tree.root, tree.box) / area : 0;
}

KdTree build_kd_tree(KdRule rule, const std::vector<Primitive>& primitives, int threads,
                     std::stop_token stop) {
  KdTree tree;
  std::vector<KdRef> refs;
  refs.reserve(primitives.size());
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    throw_if_stopped(stop, i);
    refs.push_back({box_of(primitives[i]), static_cast<std::uint32_t>(i)});
    tree.box.add(refs.back().part);
  }
  KdBuilder builder(rule, primitives, threads, std::move(stop));
  tree.root = builder.grow(std::move(refs), tree.box, 0, 0, reference_budget(primitives.size()), tree);
  return tree;
}

absl::Status build_tree(const StructureOptions& options, std::vector<Primitive>& primitives, KdTree& tree,
                        KdRule rule) {
  tree = build_kd_tree(rule, primitives, options.threads, options.stop);
  if (options.wide) widen(primitives, tree, options.stop);
  return absl::OkStatus();
}

StructureFigures figures_of(const KdTree& tree) {
  StructureFigures figures = tree.figures();
  figures.bytes += tree.wide.bytes();
  figures.sah_cost = kd_sah_cost(tree);
  return figures;
}

}  // namespace tessera::render
