#include "render/accel/bsp/bsp_tree.h"

#include <array>

#include "render/accel/structure/forks.h"
#include "render/core/stopped.h"

namespace tessera::render {

namespace {

constexpr std::size_t kBspLeaf = 4;
/// Planes of primitives that are tried at a node, evenly over them.
constexpr std::size_t kPlanesTried = 6;

struct Plane {
  std::array<float, 3> normal{};
  float place = 0;

  double operator()(const float* p) const {
    return double{normal[0]} * p[0] + double{normal[1]} * p[1] + double{normal[2]} * p[2] - place;
  }
};

/// Least and most of a plane's value over a primitive.
std::pair<double, double> reach_across(const Plane& plane, const Primitive& primitive) {
  if (primitive.kind == PrimitiveKind::kTriangle) {
    const double a = plane(primitive.corners[0]), b = plane(primitive.corners[1]),
                 c = plane(primitive.corners[2]);
    return {std::min({a, b, c}), std::max({a, b, c})};
  }
  double low = -double{plane.place}, high = low;
  for (std::size_t k = 0; k < 3; ++k) {
    const double a = double{plane.normal[k]} * primitive.corners[0][k];
    const double b = double{plane.normal[k]} * primitive.corners[1][k];
    low += std::min(a, b), high += std::max(a, b);
  }
  return {low, high};
}

/// The plane through a triangle, with a normal whose largest component is 1; none where it has no area.
bool plane_of(const Primitive& p, Plane& plane) {
  double e1[3], e2[3], n[3], most = 0;
  for (int k = 0; k < 3; ++k) {
    e1[k] = double{p.corners[1][k]} - p.corners[0][k];
    e2[k] = double{p.corners[2][k]} - p.corners[0][k];
  }
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    n[k] = e1[i] * e2[j] - e1[j] * e2[i];
    most = std::max(most, std::abs(n[k]));
  }
  if (!(most > 0)) return false;
  double place = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    plane.normal[k] = static_cast<float>(n[k] / most);
    place += double{plane.normal[k]} * p.corners[0][k];
  }
  plane.place = static_cast<float>(place);
  return std::isfinite(plane.place);
}

/// Which sides of a plane a primitive reaches into.
struct Sides {
  bool below, above;
};

class BspBuilder {
 public:
  BspBuilder(const std::vector<Primitive>& primitives, const Box& box, int threads, std::stop_token stop)
      : primitives_(primitives),
        flat_(0x1p-22 * box.largest_coordinate()),
        deepest_(static_cast<int>(
            16 + 1.5 * std::log2(static_cast<double>(std::max<std::size_t>(primitives.size(), 1))))),
        forks_(threads),
        stop_(std::move(stop)) {}

  std::int32_t grow(std::vector<std::uint32_t> refs, int depth, double budget, BspTree& tree) {
    const auto as_leaf = [&] { return tree.add_leaf(refs, [](std::uint32_t i) { return i; }); };
    Plane plane;
    if (refs.size() <= kBspLeaf || depth >= deepest_ || !choose(refs, plane)) return as_leaf();
    std::vector<std::uint32_t> parts[2];
    for (const std::uint32_t i : refs) {
      throw_if_stopped(stop_, i);
      const Sides sides = sides_of(plane, primitives_[i]);
      if (sides.below) parts[0].push_back(i);
      if (sides.above) parts[1].push_back(i);
    }
    const double below = static_cast<double>(parts[0].size());
    const double both = below + static_cast<double>(parts[1].size());
    if (both > budget) return as_leaf();
    const bool fork = refs.size() >= kForkSize;
    refs = {};
    const auto self = static_cast<std::int32_t>(tree.nodes.size());
    tree.nodes.push_back({{plane.normal[0], plane.normal[1], plane.normal[2]}, plane.place, {}});
    std::int32_t children[2];
    const auto grow_child = [&](int c, BspTree& into) {
      const double share = (c == 0 ? below : both - below) / both;
      children[c] = grow(std::move(parts[c]), depth + 1, budget * share, into);
    };
    if (fork) {
      BspTree above;
      forks_.both([&] { grow_child(0, tree); }, [&] { grow_child(1, above); });
      children[1] = tree.append(above, children[1]);
    } else {
      grow_child(0, tree);
      grow_child(1, tree);
    }
    std::copy_n(children, 2, tree.nodes[static_cast<std::size_t>(self)].child);
    return self;
  }

 private:
  /// The coefficients of a plane through a triangle are rounded; what they put off the plane by no more than
  /// that lies in it, and for that the walk makes room.
  Sides sides_of(const Plane& plane, const Primitive& primitive) const {
    const auto [low, high] = reach_across(plane, primitive);
    return {low < -flat_ || high <= flat_, high > flat_};
  }

  /// The candidate that leaves least work: the larger side, and what it cuts in two. Candidates are the
  /// median along each axis and the planes of some triangles, which no axis finds. Areas of cells, which are
  /// polyhedra here, are left aside.
  bool choose(const std::vector<std::uint32_t>& refs, Plane& best) const {
    double least = static_cast<double>(refs.size());  // parting has to bring something
    const auto consider = [&](const Plane& plane) {
      throw_if_stopped(stop_);
      std::size_t below = 0, above = 0;
      for (const std::uint32_t i : refs) {
        throw_if_stopped(stop_, i);
        const Sides sides = sides_of(plane, primitives_[i]);
        below += sides.below, above += sides.above;
      }
      if (below == refs.size() || above == refs.size()) return;
      const double cut = static_cast<double>(below + above - refs.size());
      const double cost = static_cast<double>(std::max(below, above)) + cut;
      if (cost < least) least = cost, best = plane;
    };
    std::vector<float> centres(refs.size());
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t i = 0; i < refs.size(); ++i)
        centres[i] = box_of(primitives_[refs[i]]).centre(static_cast<int>(axis));
      const auto half = centres.begin() + static_cast<std::ptrdiff_t>(centres.size() / 2);
      std::nth_element(centres.begin(), half, centres.end());
      Plane plane;
      plane.normal[axis] = 1;
      plane.place = *half;
      consider(plane);
    }
    for (std::size_t t = 0; t < kPlanesTried; ++t) {
      const Primitive& primitive = primitives_[refs[t * refs.size() / kPlanesTried]];
      Plane plane;
      if (primitive.kind == PrimitiveKind::kTriangle && plane_of(primitive, plane)) consider(plane);
    }
    return least < static_cast<double>(refs.size());
  }

  const std::vector<Primitive>& primitives_;
  const double flat_;
  const int deepest_;
  Forks forks_;
  const std::stop_token stop_;
};

}  // namespace

BspTree build_bsp_tree(const std::vector<Primitive>& primitives, int threads, std::stop_token stop) {
  BspTree tree;
  std::vector<std::uint32_t> refs(primitives.size());
  for (std::size_t i = 0; i < refs.size(); ++i) {
    throw_if_stopped(stop, i);
    refs[i] = static_cast<std::uint32_t>(i);
    tree.box.add(box_of(primitives[i]));
  }
  BspBuilder builder(primitives, tree.box, threads, std::move(stop));
  tree.root = builder.grow(std::move(refs), 0, reference_budget(primitives.size()), tree);
  return tree;
}

absl::Status build_tree(const StructureOptions& options, std::vector<Primitive>& primitives, BspTree& tree) {
  tree = build_bsp_tree(primitives, options.threads, options.stop);
  return absl::OkStatus();
}

}  // namespace tessera::render
