// Links, solutions and what is shown of them, in rooms whose light is known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "unit/render/radiosity/room.h"

namespace tessera::render::TESSERA_ISA::radiosity {
namespace {

constexpr LinkBounds kBounds{.error = 0.02, .relative_error = 0.14, .smallest_area = 1e-3};

/// Links by the brightnesses that the walls have in the end, which are no more than 1.
Forest solved(const Room& room, double residual, const LinkBounds& bounds = kBounds) {
  std::vector<Brightness::Value> sides(room.surfaces().sides());
  for (Side side = 0; side < sides.size(); side += 2) sides[side] = {1, 0};
  Forest forest = room.grow(room.link(sides, bounds));
  solve(forest, residual);
  return forest;
}

bool is_inside(const Forest::Node& node) { return node.first_part == 0 && node.name.side() % 2 == 0; }

/// Off E / (1 - rho), which all of a room has that shines and reflects alike.
struct Deviation {
  double mean = 0, largest = 0;  // relative
};
Deviation deviation_of_white_room(float reflectance, double error) {
  const Room room(cube(reflectance, 0.1f));
  LinkBounds bounds = kBounds;
  bounds.error = error;
  bounds.relative_error = std::sqrt(error);
  const Forest forest = solved(room, 1e-7, bounds);
  Deviation deviation;
  const double expected = 0.1 / (1 - double{reflectance});
  for (const Forest::Node& node : forest.nodes()) {
    if (!is_inside(node)) continue;
    const double off = double{node.radiosity.band[1]} / expected - 1;
    deviation.mean += off * room.surfaces().patch(node.name).area / 6;
    deviation.largest = std::max(deviation.largest, std::abs(off));
  }
  return deviation;
}

TEST(Radiosity, AWhiteRoomIsBrightEverywhere) {
  // All form factors of a point add up to 1 exactly; a patch has those of larger ones around it where the
  // bound allows, a few of them each off by the bound.
  for (const float reflectance : {0.3f, 0.8f}) {
    const Deviation coarse = deviation_of_white_room(reflectance, 0.04),
                    fine = deviation_of_white_room(reflectance, 0.01);
    EXPECT_LT(std::abs(coarse.mean), 0.02);
    EXPECT_LT(coarse.largest, 5 * 0.04);
    EXPECT_LT(std::abs(fine.mean), 0.005);
    EXPECT_LT(fine.largest, 5 * 0.01);
    EXPECT_LT(fine.largest, coarse.largest);
  }
}

TEST(Radiosity, ABoxInAWhiteRoomIsAsBright) {
  // Anything that hides a wall is as bright as the wall.
  std::vector<Square> squares = cube(0.7f, 0.1f);
  for (Square wall : cube(0.7f, 0.1f)) {
    std::swap(wall.a, wall.b);  // seen from outside
    for (Vec* v : {&wall.corner, &wall.a, &wall.b}) *v = *v * 0.4;
    wall.corner = wall.corner + Vec{0.27, 0.01, 0.33};
    squares.push_back(wall);
  }
  const Room room(squares, false);
  const Forest forest = solved(room, 1e-7);
  double mean = 0, area = 0;
  for (const Forest::Node& node : forest.nodes()) {
    if (!is_inside(node)) continue;
    const double own = room.surfaces().patch(node.name).area;
    area += own;
    mean += own * double{node.radiosity.band[0]};
  }
  // Five rays tell a hidden part to a fifth, and what is hidden in the smallest patches is not split.
  EXPECT_NEAR(mean / area, 0.1 / 0.3, 0.06 * 0.1 / 0.3);
}

TEST(Radiosity, AllThatIsEmittedIsAbsorbed) {
  std::vector<Square> walls = cube(0.6f, 0);
  walls[1].exitance = 1;  // the ceiling
  const Room room(walls);
  const Forest forest = solved(room, 1e-7);
  double absorbed = 0, emitted = 0;
  for (const Forest::Node& node : forest.nodes()) {
    if (!is_inside(node)) continue;
    const double area = room.surfaces().patch(node.name).area;
    absorbed += area * (1 - 0.6) * double{node.irradiance.band[0]};
    emitted += area * double{node.matter.emission.band[0]};
  }
  EXPECT_NEAR(emitted, 1, 1e-6);
  // Half of the bound of a link, as they err to both sides.
  EXPECT_NEAR(absorbed, emitted, 0.01);
}

TEST(Radiosity, ASmallLampLightsTheWholeRoom) {
  std::vector<Square> walls = cube(0.6f, 0);
  walls.push_back({{0.35, 0.98, 0.4}, {0.3, 0, 0}, {0, 0, 0.2}, 0, 10});
  const Room room(walls, false);
  std::vector<Brightness::Value> sides(room.surfaces().sides());
  for (Side side = 0; side < 24; side += 2) sides[side] = {0.3f, 0};
  sides[24] = sides[26] = {10, 10};
  Forest forest = room.grow(room.link(sides, kBounds));
  solve(forest, 1e-7);
  double absorbed = 0;
  for (const Forest::Node& node : forest.nodes()) {
    if (node.first_part != 0) continue;
    const double area = room.surfaces().patch(node.name).area;
    absorbed += area * (1 - double{node.matter.reflectance.band[0]}) * double{node.irradiance.band[0]};
  }
  // Shadows and corners at the smallest patches take some per cent of the largest link, the lamp's.
  EXPECT_NEAR(absorbed, 0.6, 0.05 * 0.6);
}

TEST(Radiosity, TheResidualFalls) {
  std::vector<Square> walls = cube(0.7f, 0);
  walls[1].exitance = 1;
  const Room room(walls);
  std::vector<Brightness::Value> sides(room.surfaces().sides(), {1, 0});
  const Links links = room.link(sides, kBounds);
  int last = 0;
  for (const double residual : {1e-1, 1e-3, 1e-5}) {
    Forest forest = room.grow(links);
    const Forest::Outcome outcome = solve(forest, residual);
    EXPECT_LE(outcome.residual, residual);
    EXPECT_GT(outcome.sweeps, last);
    last = outcome.sweeps;
  }
}

TEST(Radiosity, LinksOfPartsAreThoseOfTheWhole) {
  const Room room(cube(0.5f, 0.1f));
  std::vector<Brightness::Value> sides(room.surfaces().sides(), {1, 0});
  const Links links = room.link(sides, kBounds);
  Links first, second;
  for (const Link& link : links.links) (link.receiver.side() < 7 ? first : second).links.push_back(link);
  Links merged;
  ASSERT_TRUE(merged.append(first.blob()));
  ASSERT_TRUE(merged.append(second.blob()));
  EXPECT_EQ(merged.blob(), links.blob());
  EXPECT_FALSE(merged.append(links.blob().substr(1)));
  EXPECT_FALSE(merged.append("links"));
}

TEST(Clusters, HoldEachSideOnce) {
  const Room room(cube(0.5f, 0));
  const std::vector<Cluster>& all = room.clusters().all();
  std::vector<int> seen(room.surfaces().sides());
  for (const Cluster& cluster : all) {
    if (cluster.count == 1) ++seen[room.clusters().only_side(cluster)];
  }
  for (const int times : seen) EXPECT_EQ(times, 1);
  EXPECT_NEAR(all.front().area, 12, 1e-12);
  for (double at = 0.01; at < 1; at += 0.09) {
    double u = at;
    EXPECT_LT(room.clusters().side_at(all.front(), u), room.surfaces().sides());
    EXPECT_GE(u, 0);
    EXPECT_LT(u, 1);
  }
}

TEST(Names, LeadBackToTheirPatches) {
  const Room room(cube(0.5f, 0));
  Name name = Name::of_side(6);
  const Patch whole = room.surfaces().patch(name);
  for (const unsigned part : {3u, 0u, 2u, 1u, 3u}) {
    name = name.part(part);
    EXPECT_EQ(name.part_at(name.level() - 1), part);
  }
  EXPECT_EQ(name.level(), 5);
  EXPECT_EQ(name.side(), 6u);
  const Patch patch = room.surfaces().patch(name);
  EXPECT_DOUBLE_EQ(patch.area, whole.area / 1024);
  EXPECT_NEAR(length(cross(patch.corner[1] - patch.corner[0], patch.corner[2] - patch.corner[0])) / 2,
              patch.area, 1e-15);
}

TEST(Display, IsContinuousAcrossPatchesOfAllSizes) {
  std::vector<Square> walls = cube(0.5f, 0);
  walls[2].exitance = 1;  // near the floor's edge, which is split more finely there
  const Room room(walls);
  const Forest forest = solved(room, 1e-5, {.error = 0.05, .relative_error = 0.3, .smallest_area = 1e-5});
  const Solution solution = show(room.shapes(), room.surfaces(), forest);
  // On both sides of the diagonal that the floor's triangles share, and of lines between patches: a step
  // would be some per cent; 1e-9 away, what is continuous changes by less than 1e-6.
  constexpr double kStep = 1e-9;
  int levels = 0;
  for (int i = 1; i < 1024; ++i) {
    const double t = i / 1024.0 + 1e-5;
    const Shown a = look_up(solution, 0, {{1 - t, kStep, t - kStep}});
    const Shown b = look_up(solution, 2, {{1 - t, t - kStep, kStep}});
    EXPECT_NEAR(a.irradiance.band[0], b.irradiance.band[0], 1e-5) << t;
    levels |= 1 << a.patch_level;
    const double line = i / 1024.0;
    for (const Side side : {0u, 2u}) {
      const double u = 0.3 * (1 - line);
      const Shown left = look_up(solution, side, {{1 - line - u, line - kStep, u + kStep}});
      const Shown right = look_up(solution, side, {{1 - line - u, line + kStep, u - kStep}});
      EXPECT_NEAR(left.irradiance.band[0], right.irradiance.band[0], 1e-5) << line;
    }
  }
  EXPECT_NE(levels & (levels - 1), 0) << "patches of several sizes";
}

TEST(Display, ShowsTheMeanOfThePatches) {
  const Room room(cube(0.5f, 0.1f));
  const Forest forest = solved(room, 1e-6);
  const Solution solution = show(room.shapes(), room.surfaces(), forest);
  const Shown shown = look_up(solution, 0, {{0.2, 0.5, 0.3}});
  EXPECT_NEAR(shown.irradiance.band[2], 0.2, 5 * 0.02 * 0.2);
  const std::optional<Solution> read = Solution::read(solution.blob());
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->blob(), solution.blob());
  EXPECT_FALSE(Solution::read(solution.blob().substr(1)).has_value());
}

TEST(Display, TrianglesWithoutAreaChangeNoLight) {
  // One along an edge of the floor, of the same paint: it is not split, so that its edge would be straight
  // from end to end.
  std::vector<Square> walls = cube(0.5f, 0);
  walls[4].exitance = 1;
  const Room without(walls);
  walls.push_back({{0, 0, 0}, {0.5, 0, 0}, {0.5, 0, 0}, 0.5f, 0, 4});
  const Room room(walls);
  ASSERT_EQ(room.surfaces().area(24), 0);
  const auto shown = [](const Room& seen) {
    return show(seen.shapes(), seen.surfaces(), solved(seen, 1e-5));
  };
  const Solution expected = shown(without), solution = shown(room);
  double low = 1e9, high = 0;
  for (int i = 1; i < 256; ++i) {
    const double t = i / 256.0;
    // The edge from the wall's first corner to its second.
    const float light = look_up(expected, 16, {{1 - t, t, 0}}).irradiance.band[0];
    EXPECT_EQ(look_up(solution, 16, {{1 - t, t, 0}}).irradiance.band[0], light) << t;
    low = std::min(low, double{light}), high = std::max(high, double{light});
  }
  EXPECT_GT(high - low, 0.02 * high) << "light changes along the edge";
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA::radiosity
