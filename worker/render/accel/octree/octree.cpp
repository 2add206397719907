#include "render/accel/octree/octree.h"

#include <array>

#include "render/accel/structure/clip.h"
#include "render/accel/structure/forks.h"
#include "render/core/stopped.h"

namespace tessera::render {

namespace {

constexpr std::size_t kOctreeLeaf = 8;
/// The smallest cells have a side of 2^-20 of the whole: floats still tell their ends apart.
constexpr int kOctreeDepth = 20;
/// A cell whose parts hold so many times what it held is not worth parting.
constexpr double kWorthwhile = 3;

class OctreeBuilder {
 public:
  OctreeBuilder(const std::vector<Primitive>& primitives, int threads, std::stop_token stop)
      : primitives_(primitives), forks_(threads), stop_(std::move(stop)) {}

  std::int32_t grow(std::vector<std::uint32_t> refs, const Box& cell, int depth, double budget,
                    Octree& tree) {
    const auto as_leaf = [&] { return tree.add_leaf(refs, [](std::uint32_t i) { return i; }); };
    if (refs.size() <= kOctreeLeaf || depth >= kOctreeDepth) return as_leaf();
    const float centre[3] = {cell.centre(0), cell.centre(1), cell.centre(2)};
    std::array<std::vector<std::uint32_t>, 8> parts;
    std::array<Box, 8> cells;
    std::size_t all = 0, most = 0;
    for (std::size_t c = 0; c < 8; ++c) {
      cells[c] = cell;
      for (std::size_t k = 0; k < 3; ++k) (c >> k & 1 ? cells[c].low : cells[c].high)[k] = centre[k];
      for (const std::uint32_t i : refs) {
        throw_if_stopped(stop_);
        if (!part_within(primitives_[i], cells[c]).empty()) parts[c].push_back(i);
      }
      all += parts[c].size(), most = std::max(most, parts[c].size());
    }
    const auto n = static_cast<double>(refs.size()), sum = static_cast<double>(all);
    // Nested cells may peel off empty space for some steps, but what they cannot tell apart is not parted on.
    if (sum > budget || (most == refs.size() && sum > kWorthwhile * n)) return as_leaf();
    const bool fork = refs.size() >= kForkSize;
    refs = {};
    const auto self = static_cast<std::int32_t>(tree.nodes.size());
    OctreeNode node;
    std::copy_n(centre, 3, node.centre);
    tree.nodes.push_back(node);
    std::array<std::int32_t, 8> children;
    const auto grow_some = [&](std::size_t from, std::size_t to, Octree& into) {
      for (std::size_t c = from; c < to; ++c) {
        const double share = sum > 0 ? static_cast<double>(parts[c].size()) / sum : 0;
        children[c] = grow(std::move(parts[c]), cells[c], depth + 1, budget * share, into);
      }
    };
    if (fork) {
      Octree upper;
      forks_.both([&] { grow_some(0, 4, tree); }, [&] { grow_some(4, 8, upper); });
      // Each root among them keeps its place.
      const std::int32_t node_base = static_cast<std::int32_t>(tree.nodes.size());
      const std::int32_t leaf_base = static_cast<std::int32_t>(tree.leaves.size());
      tree.append(upper, -1);
      for (std::size_t c = 4; c < 8; ++c) children[c] += children[c] >= 0 ? node_base : -leaf_base;
    } else {
      grow_some(0, 8, tree);
    }
    std::ranges::copy(children, tree.nodes[static_cast<std::size_t>(self)].child);
    return self;
  }

 private:
  const std::vector<Primitive>& primitives_;
  Forks forks_;
  const std::stop_token stop_;
};

}  // namespace

Octree build_octree(const std::vector<Primitive>& primitives, int threads, std::stop_token stop) {
  Octree tree;
  std::vector<std::uint32_t> refs(primitives.size());
  for (std::size_t i = 0; i < refs.size(); ++i) {
    throw_if_stopped(stop, i);
    refs[i] = static_cast<std::uint32_t>(i);
    tree.box.add(box_of(primitives[i]));
  }
  OctreeBuilder builder(primitives, threads, std::move(stop));
  tree.root = builder.grow(std::move(refs), tree.box, 0, reference_budget(primitives.size()), tree);
  return tree;
}

absl::Status build_tree(const StructureOptions& options, std::vector<Primitive>& primitives, Octree& tree) {
  tree = build_octree(primitives, options.threads, options.stop);
  return absl::OkStatus();
}

}  // namespace tessera::render
