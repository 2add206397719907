// Bounds of radiosity's memory and light, and blobs that are none of its own.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "render/textbook/radiosity/memory.h"
#include "unit/render/radiosity/room.h"

namespace tessera::render::TESSERA_ISA::radiosity::limits_test {
namespace {

constexpr std::size_t kLeastLinks = render::radiosity::kLeastLinks;
constexpr LinkBounds kBounds{.error = 0.02, .relative_error = 0.14, .smallest_area = 1e-3};

/// The cube's walls, each cut into count x count squares.
std::vector<Square> tiles(int count) {
  std::vector<Square> all;
  for (Square wall : cube(0.5f, 0.1f)) {
    const Vec corner = wall.corner, a = wall.a * (1.0 / count), b = wall.b * (1.0 / count);
    wall.a = a, wall.b = b;
    for (int i = 0; i < count * count; ++i) {
      wall.corner = corner + a * (i % count) + b * (i / count);
      all.push_back(wall);
    }
  }
  return all;
}

TEST(RadiosityLimits, LinksKeepToTheirNumber) {
  const Room room(cube(0.5f, 0.1f));
  const std::vector<Brightness::Value> sides(room.surfaces().sides(), {1, 0});
  LinkBounds bounds = kBounds;
  const std::size_t all = room.link(sides, bounds).links.size();
  bounds.links_per_side = kLeastLinks;
  bounds.links_per_area = 200;
  const Links few = room.link(sides, bounds);
  const double most = 24 * kLeastLinks + 200 * 2 * room.surfaces().whole_area();
  EXPECT_GT(static_cast<double>(all), 2 * most) << "there is something to cut";
  EXPECT_LE(static_cast<double>(few.links.size()), most);
  EXPECT_GT(few.cut_short, 0u);
  // The rest is coarse, but a solution.
  Forest forest = room.grow(few);
  solve(forest, 1e-5);
  EXPECT_NEAR(forest.node(0).radiosity.band[0], 0.2, 0.02);
}

TEST(RadiosityLimits, LinksBetweenWholeSidesKeepToTheirNumber) {
  // The estimate allows clusters of a form factor of 0.01 at most, unless there is no room for them.
  const Room room(tiles(6));
  const std::vector<Brightness::Value> sides(room.surfaces().sides(), {1, 0});
  LinkBounds bounds{.split = false, .error = 1, .factor = 0.01, .rays = 2};
  const auto most_of_a_side = [](const Links& links) {
    std::map<Side, std::size_t> count;
    for (const Link& link : links.links) ++count[link.receiver.side()];
    std::size_t most = 0;
    for (const auto& [side, number] : count) most = std::max(most, number);
    return most;
  };
  EXPECT_GT(most_of_a_side(room.link(sides, bounds)), 4 * kLeastLinks) << "there is something to cut";
  bounds.links_per_side = kLeastLinks;
  const Links few = room.link(sides, bounds);
  EXPECT_LE(most_of_a_side(few), kLeastLinks);
  EXPECT_EQ(few.cut_short, room.surfaces().sides()) << "each is told";
  // They end at larger clusters, and not in the dark.
  Forest forest = room.grow(few);
  solve(forest, 1e-4);
  for (Side side = 0; side < room.surfaces().sides(); side += 2)
    EXPECT_GT(forest.node(side).irradiance.band[0], 0) << side;
}

TEST(RadiosityLimits, LightsThatAreDecidedAtOnePatchAreOneEntry) {
  std::vector<PointLamp> lamps;
  for (int i = 0; i < 500; ++i) lamps.push_back({{0.5, 0.2 + 0.001 * i, 0.4}, 0.01f});
  const Room room(tiles(2), true, lamps);
  const std::vector<Brightness::Value> sides(room.surfaces().sides(), {0, 0});
  // Without a split, each side has all of them; with few, lights take no more than their share.
  for (const bool split : {false, true}) {
    LinkBounds bounds{.split = split, .error = 1e-4, .smallest_area = 1e-3, .links_per_side = 200};
    const Links links = room.link(sides, bounds);
    std::map<Side, std::size_t> entries;
    std::map<std::uint64_t, double> by_patch;
    for (const DirectLight& light : links.direct) {
      ++entries[light.receiver.side()];
      EXPECT_TRUE(by_patch.emplace(light.receiver.bits(), light.irradiance.band[0]).second);
    }
    for (const auto& [side, count] : entries) EXPECT_LE(count, split ? 300u : 1u) << side;
    EXPECT_EQ(entries.size(), room.surfaces().sides() / 2) << "all that face the room";
    if (split) continue;
    // The floor's first triangle has the light of all of them, by 48 points: the mean over a fine grid.
    const Patch patch = room.surfaces().patch(Name::of_side(0));
    double expected = 0;
    constexpr int kSteps = 60;
    for (int i = 0; i < kSteps; ++i) {
      for (int j = 0; i + j < kSteps; ++j) {
        // The middles of the cells below the diagonal; those on it are half cells.
        const double u = (i + 0.5) / kSteps, v = (j + 0.5) / kSteps, cell = i + j + 1 < kSteps ? 2 : 1;
        for (const PointLamp& lamp : lamps) {
          const Vec way = lamp.place - patch.point({{1 - u - v, u, v}});
          const double square = dot(way, way);
          expected += 0.01 * dot(way, patch.normal) / (square * std::sqrt(square)) * cell / (kSteps * kSteps);
        }
      }
    }
    EXPECT_NEAR(by_patch[Name::of_side(0).bits()], expected, 0.03 * expected);
  }
}

TEST(RadiosityLimits, FactorsThatAreTooLargeMakeNoLight) {
  // Each receiver has a third more of all others than there is: with 0.9, light would grow by a fifth a
  // sweep.
  const Room room(cube(0.9f, 0.1f));
  std::vector<Brightness::Value> sides(room.surfaces().sides());
  for (Side side = 0; side < sides.size(); side += 2) sides[side] = {1, 0};
  Links links = room.link(sides, kBounds);
  for (Link& link : links.links) link.factor = std::min(link.factor * 4 / 3, 1.0);
  Forest forest = room.grow(links);
  EXPECT_LE(solve(forest, 1e-6).residual, 1e-6);
  for (const Forest::Node& node : forest.nodes()) {
    if (node.first_part != 0 || node.name.side() % 2 != 0) continue;
    EXPECT_NEAR(node.radiosity.band[0], 0.1 / (1 - 0.9), 1e-3);
  }
}

TEST(RadiosityLimits, SweepsThatCannotHelpEnd) {
  std::vector<Square> walls = cube(0.5f, 0);
  walls[1].exitance = std::numeric_limits<float>::infinity();
  const Room room(walls);
  const std::vector<Brightness::Value> sides(room.surfaces().sides(), {1, 0});
  Forest forest = room.grow(room.link(sides, {.error = 0.2, .smallest_area = 0.1}));
  const Forest::Outcome outcome = solve(forest, 1e-4);
  EXPECT_FALSE(outcome.residual <= 1e-4);
  EXPECT_LT(outcome.sweeps, 10);
}

TEST(RadiosityLimits, ForestsRefuseWhatNoLinkerMakes) {
  Room room(cube(0.5f, 0.1f));
  const auto grows = [&](const Link& link, int deepest = Name::kDeepest) {
    Links links;
    links.links.push_back(link);
    return room.grows(links, deepest);
  };
  const Name side = Name::of_side(0), other = Name::of_side(23);
  EXPECT_TRUE(grows({side, other, 0.5}));
  EXPECT_FALSE(grows({side, Name::of_side(24), 0.5}));
  EXPECT_FALSE(grows({Name::of_side(24), side, 0.5}));
  EXPECT_FALSE(grows({side, Name::of_cluster(1000), 0.5}));
  EXPECT_FALSE(grows({Name::of_cluster(0), side, 0.5}));
  for (const double factor : {-0.1, 1.1, double{INFINITY}, double{NAN}})
    EXPECT_FALSE(grows({side, other, factor})) << factor;
  EXPECT_TRUE(grows({side.part(2), other, 0.5}));
  EXPECT_FALSE(grows({side.part(2), other, 0.5}, 0)) << "the estimate has whole sides alone";
  EXPECT_FALSE(grows({side, other.part(1), 0.5}, 0));
  for (const float irradiance : {-1.0f, INFINITY, NAN}) {
    Links links;
    links.direct.push_back({side, {{1, irradiance, 1}}, 1});
    EXPECT_FALSE(room.grows(links)) << irradiance;
  }
  // 24 sides and 56 parts that lead to a deepest patch.
  Name deepest = side;
  while (deepest.level() < Name::kDeepest) deepest = deepest.part(3);
  room.set_memory_limit(80 * render::radiosity::kBytesPerNode);
  EXPECT_TRUE(grows({deepest, other, 0.5}));
  room.set_memory_limit(80 * render::radiosity::kBytesPerNode - 1);
  EXPECT_FALSE(grows({deepest, other, 0.5}));
}

TEST(RadiosityLimits, SolutionsAreForestsOfFewLevels) {
  const Room room(cube(0.5f, 0.1f));
  Links links;
  links.links.push_back({Name::of_side(0).part(1), Name::of_side(4), 0.2});
  const Solution solution = show(room.shapes(), room.surfaces(), room.grow(links));
  ASSERT_EQ(solution.nodes.size(), 28u);
  const auto reads = [](const Solution& changed) { return Solution::read(changed.blob()).has_value(); };
  EXPECT_TRUE(reads(solution));
  Solution broken = solution;
  broken.nodes[0] = 0;  // its own part
  EXPECT_FALSE(reads(broken));
  broken = solution;
  broken.nodes[2] = broken.nodes[0];  // two have the same parts
  EXPECT_FALSE(reads(broken));
  broken = solution;
  broken.nodes[0] = 20;  // sides as parts
  EXPECT_FALSE(reads(broken));
  broken = solution;
  broken.nodes.push_back(-1);  // the part of none
  EXPECT_FALSE(reads(broken));
  broken = solution;
  broken.turned.pop_back();
  EXPECT_FALSE(reads(broken));
  // Each the first part of the one before: 14 levels, and one more.
  broken = solution;
  for (int level = 2; level <= 15; ++level) {
    EXPECT_TRUE(reads(broken)) << level;
    const std::size_t last = broken.nodes.size() - 4;
    broken.nodes[last] = static_cast<std::int32_t>(broken.nodes.size());
    broken.nodes.insert(broken.nodes.end(), 4, -1);
  }
  EXPECT_FALSE(reads(broken));
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA::radiosity::limits_test
