#include "render/light/selection/light_tree_build.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "render/light/light_build.h"
#include "render/light/light_source.h"

namespace tessera::render {
namespace {

constexpr double kPi64 = std::numbers::pi;
constexpr int kBuckets = 12;

using namespace vec64;

/// Directions about an axis.
struct Cone {
  Vec axis = {0, 0, 1};
  double angle = 0;  // half of it
};

/// The smallest cone about two [Conty Estevez & Kulla 2018, algorithm 1].
Cone around(Cone a, Cone b) {
  if (b.angle > a.angle) std::swap(a, b);
  const double between = std::acos(std::clamp(dot(a.axis, b.axis), -1.0, 1.0));
  if (std::min(between + b.angle, kPi64) <= a.angle) return a;
  const double angle = (a.angle + between + b.angle) / 2;
  if (angle >= kPi64) return {a.axis, kPi64};
  const Vec across = cross(cross(a.axis, b.axis), a.axis);
  // All but parallel: there is no plane to turn in, and nothing to turn by.
  if (length(across) < 1e-7) return {a.axis, dot(a.axis, b.axis) > 0 ? std::min(angle + 1e-7, kPi64) : kPi64};
  const double turn = angle - a.angle;
  return {unit(a.axis * std::cos(turn) + unit(across) * std::sin(turn)), angle};
}

/// Bounds of a set of lights: places, directions, intensity.
struct Bounds : LightBounds {
  Bounds() = default;
  explicit Bounds(const LightBounds& one) : LightBounds(one) {}

  using LightBounds::add;
  void add(const Bounds& b) {
    const Cone both = intensity > 0 ? around({axis, angle}, {b.axis, b.angle}) : Cone{b.axis, b.angle};
    axis = both.axis, angle = both.angle;
    for (std::size_t c = 0; c < 3; ++c) {
      low[c] = std::min(low[c], b.low[c]);
      high[c] = std::max(high[c], b.high[c]);
    }
    reach = std::max(reach, b.reach);
    intensity += b.intensity;
    two_sided |= b.two_sided;
  }
  Vec centre() const { return (low + high) * 0.5; }
  Vec size() const { return high - low; }
};

struct Item {
  Bounds bounds;
  std::int32_t light;
};

/// The measure of directions that lights shine in, weighed by a cosine [Conty Estevez & Kulla 2018, equation
/// 1].
double directions(const Bounds& b) {
  const double o = b.angle, w = std::min(o + b.reach, kPi64);
  return 2 * kPi64 * (1 - std::cos(o)) +
         kPi64 / 2 * (2 * w * std::sin(o) - std::cos(o - 2 * w) - 2 * o * std::sin(o) + std::cos(o));
}

double area(const Bounds& b) {
  const Vec s = b.size();
  return 2 * (s[0] * s[1] + s[1] * s[2] + s[2] * s[0]);
}

class Builder {
 public:
  explicit Builder(LightTree& tree) : tree_(tree) {}

  /// Makes node `node` of `items`, reached by the low 4 `depth` bits of `path`.
  void build(std::span<Item> items, std::size_t node, std::uint32_t path, int depth) {
    // A path has 32 bits: parts of equal size only, once no more levels are left than they need.
    const bool halves = depth >= 7 || items.size() > std::size_t{1} << (4 * (7 - depth));
    std::vector<Group> groups = {Group(items)};
    while (groups.size() < kLightTreeWidth) {
      const auto worst = std::max_element(groups.begin(), groups.end(), [&](const Group& a, const Group& b) {
        return halves ? a.items.size() < b.items.size() : a.cost < b.cost;
      });
      if (worst->items.size() == 1) break;
      const std::size_t middle = split(worst->items, halves);
      const std::span<Item> rest = worst->items.subspan(middle);
      *worst = Group(worst->items.first(middle));
      groups.emplace_back(rest);
    }
    for (std::size_t k = 0; k < groups.size(); ++k) {
      const std::uint32_t way = path | static_cast<std::uint32_t>(k) << (4 * depth);
      const std::span<Item> part = groups[k].items;
      describe(part, groups[k].bounds, tree_.nodes[node], k);
      if (part.size() == 1) {
        tree_.nodes[node].link[k] = ~part[0].light;
        tree_.paths[static_cast<std::size_t>(part[0].light)] = way;
        continue;
      }
      const std::size_t child = tree_.nodes.size();
      tree_.nodes.emplace_back();
      tree_.nodes[node].link[k] = static_cast<std::int32_t>(child);
      build(part, child, way, depth + 1);
    }
  }

 private:
  struct Group {
    std::span<Item> items;
    Bounds bounds;
    double cost = -1;  // of not splitting it

    explicit Group(std::span<Item> of) : items(of) {
      for (const Item& item : items) bounds.add(item.bounds);
      if (items.size() > 1) cost = cost_of(bounds);
    }
  };

  struct Split {
    double cost = INFINITY;
    std::size_t axis = 0;
    int bucket = 0;
  };

  static int bucket_of(const Item& item, std::size_t axis, double low, double size) {
    return std::clamp(static_cast<int>(kBuckets * (item.bounds.centre()[axis] - low) / size), 0,
                      kBuckets - 1);
  }

  /// Reorders `items` so that the first so many are one part.
  static std::size_t split(std::span<Item> items, bool halves) {
    Bounds all, centres;
    for (const Item& item : items) {
      all.add(item.bounds);
      centres.add(item.bounds.centre());
    }
    const Split best = halves ? Split{} : cheapest_split(items, all, centres);
    if (best.cost == INFINITY) {
      std::size_t axis = 0;
      for (std::size_t c = 1; c < 3; ++c)
        if (centres.size()[c] > centres.size()[axis]) axis = c;
      const auto middle = items.begin() + static_cast<std::ptrdiff_t>(items.size() / 2);
      std::nth_element(items.begin(), middle, items.end(), [axis](const Item& a, const Item& b) {
        return std::pair{a.bounds.centre()[axis], a.light} < std::pair{b.bounds.centre()[axis], b.light};
      });
      return items.size() / 2;
    }
    const auto middle = std::partition(items.begin(), items.end(), [&](const Item& item) {
      return bucket_of(item, best.axis, centres.low[best.axis], centres.size()[best.axis]) <= best.bucket;
    });
    return static_cast<std::size_t>(middle - items.begin());
  }

  /// By the surface area orientation heuristic.
  static Split cheapest_split(std::span<const Item> items, const Bounds& all, const Bounds& centres) {
    Split best;
    const Vec size = all.size();
    const double largest = std::max({size[0], size[1], size[2]});
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double low = centres.low[axis], extent = centres.size()[axis];
      if (!(extent > 0) || !(size[axis] > 0)) continue;
      std::array<Bounds, kBuckets> buckets;
      for (const Item& item : items)
        buckets[static_cast<std::size_t>(bucket_of(item, axis, low, extent))].add(item.bounds);
      std::array<double, kBuckets> above{};  // cost of the buckets from here on
      Bounds sum;
      for (std::size_t i = kBuckets; i-- > 1;) above[i] = add_cost(buckets[i], sum);
      sum = {};
      for (std::size_t i = 0; i + 1 < kBuckets; ++i) {
        const double below = add_cost(buckets[i], sum),
                     cost = (below + above[i + 1]) * (largest / size[axis]);
        if (below > 0 && above[i + 1] > 0 && cost < best.cost) best = {cost, axis, static_cast<int>(i)};
      }
    }
    return best;
  }

  static double add_cost(const Bounds& bucket, Bounds& sum) {
    if (bucket.intensity > 0) sum.add(bucket);
    return sum.intensity > 0 ? cost_of(sum) : 0;
  }

  static double cost_of(const Bounds& b) {
    // Flat bounds, and points, have some area all the same: they are there.
    return b.intensity * directions(b) * (area(b) + 1e-300);
  }

  /// Fills child `k`.
  static void describe(std::span<const Item> items, const Bounds& b, LightTreeNode& node, std::size_t k) {
    const Vec centre = b.centre();
    // The roundings of the centre and of the receiver are within the sphere, too.
    const double rounding = 1e-7 * (std::abs(centre[0]) + std::abs(centre[1]) + std::abs(centre[2]));
    const double radius = (length(b.size()) / 2 + rounding) * (1 + 1e-6);
    node.radius[k] = static_cast<float>(radius);
    node.most_spread[k] = static_cast<float>(std::min(4 / (radius * radius), 1e36));

    const auto normal = [&](const Item& item) {
      const Vec& n = item.bounds.axis;
      return b.two_sided && dot(n, items[0].bounds.axis) < 0 ? n * -1 : n;
    };
    Vec sum{};
    for (const Item& item : items)
      sum = sum + normal(item) * (item.bounds.intensity * std::max(std::cos(item.bounds.angle), 0.0));
    const Vec axis = unit(sum);
    double reach = 0;
    for (const Item& item : items) {
      const double off = std::acos(std::clamp(dot(axis, normal(item)), -1.0, 1.0));
      reach = std::max(reach, off + item.bounds.angle + item.bounds.reach);
    }
    for (std::size_t c = 0; c < 3; ++c) {
      node.centre[c][k] = static_cast<float>(centre[c]);
      node.axis[c][k] = static_cast<float>(axis[c]);
    }
    node.mean[k] = static_cast<float>(std::min(length(sum) / b.intensity, 1.0));
    node.cos_reach[k] = reach < kPi64 ? static_cast<float>(std::cos(reach)) : -2.0f;
    node.sin_reach[k] = reach < kPi64 ? static_cast<float>(std::sin(reach)) : 0.0f;
    node.intensity[k] = std::max(static_cast<float>(b.intensity), 1e-37f);
    node.two_sided[k] = b.two_sided;
  }

  LightTree& tree_;
};

bool is_bounded(const LightTable& table, const LightRecord& light) {
  return !table.sources(light.kind).traits.at_infinity;
}

}  // namespace

int count_bounded_lights(const LightTable& table) {
  return static_cast<int>(std::count_if(
      table.lights.begin(), table.lights.end(),
      [&](const LightRecord& light) { return is_bounded(table, light) && sampled_power(table, light) > 0; }));
}

LightTree build_light_tree(const LightTable& table) {
  LightTree tree;
  std::vector<Item> items;
  for (std::size_t i = 0; i < table.lights.size(); ++i) {
    const LightRecord& light = table.lights[i];
    if (!(sampled_power(table, light) > 0)) continue;
    if (is_bounded(table, light)) {
      items.push_back({Bounds(table.sources(light.kind).bounds(table, light)), static_cast<std::int32_t>(i)});
    } else {
      tree.unbounded.push_back(static_cast<std::int32_t>(i));
    }
  }
  const std::size_t ways = tree.unbounded.size() + (items.empty() ? 0 : 1);
  if (ways == 0) return {};
  tree.paths.assign(table.lights.size(), 0);
  tree.shares.assign(table.lights.size(), 0.0f);
  const float share = 1.0f / static_cast<float>(ways);
  for (const std::int32_t light : tree.unbounded) tree.shares[static_cast<std::size_t>(light)] = share;
  for (const Item& item : items) tree.shares[static_cast<std::size_t>(item.light)] = share;
  if (!items.empty()) {
    tree.nodes.resize(1);
    Builder(tree).build(items, 0, 0, 0);
    tree.root_children =
        static_cast<int>(std::ranges::count_if(tree.nodes[0].intensity, [](float i) { return i > 0; }));
  }
  for (std::size_t i = 0; i < table.lights.size(); ++i) {
    if (const std::int32_t other = table.lights[i].same_as; other >= 0) {
      tree.paths[i] = tree.paths[static_cast<std::size_t>(other)];
      tree.shares[i] = tree.shares[static_cast<std::size_t>(other)];
    }
  }
  return tree;
}

}  // namespace tessera::render
