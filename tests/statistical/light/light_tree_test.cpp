// Are lights picked as often as their probabilities say, and all that can be seen?
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "render/light/selection/light_tree_build.h"
#include "render/light/selection/pick.h"
#include "statistical/light/lamps.h"
#include "support/kernel/chi2.h"

namespace tessera::render::TESSERA_ISA {
namespace {

Point random_point(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> u(-size, size);
  const double x = u(random), y = u(random);
  return {x, y, u(random)};
}

/// Lamps of all kinds, 110 of them, in a box of size 2 about the origin; two at infinity.
Lamp many_lamps() {
  std::mt19937 random(4);
  std::vector<Point> vertices;
  std::vector<std::uint32_t> indices;
  for (std::uint32_t i = 0; i < 60; ++i) {
    const Point at = random_point(random, 1);
    for (int k = 0; k < 3; ++k) vertices.push_back(at + random_point(random, 0.1));
    for (std::uint32_t k = 0; k < 3; ++k) indices.push_back(3 * i + k);
  }
  Lamp lamp = mesh_lamp("many", vertices, indices, false);
  std::vector<LightRecord>& lights = lamp.table.lights;
  for (int i = 0; i < 60; i += 3) lights[static_cast<std::size_t>(i)].two_sided = 1;
  const auto add = [&](LightKind kind) -> LightRecord& {
    LightRecord& light = lights.emplace_back();
    light.kind = kind;
    const Point at = random_point(random, 1), axis = unit(random_point(random, 1));
    const double p[] = {at.x, at.y, at.z}, d[] = {axis.x, axis.y, axis.z};
    for (std::size_t c = 0; c < 3; ++c) {
      light.position[c] = static_cast<float>(p[c]);
      light.direction[c] = static_cast<float>(d[c]);
      light.radiance[c] = 0.02f * static_cast<float>(c + 1);
    }
    return light;
  };
  for (int i = 0; i < 20; ++i) add(LightKind::kPoint);
  for (int i = 0; i < 18; ++i) {
    LightRecord& spot = add(LightKind::kSpot);
    spot.cos_inner = 0.9f;
    spot.cos_outer = 0.7f;
  }
  for (int i = 0; i < 10; ++i) {
    LightRecord& soft = add(i < 5 ? LightKind::kSoftPoint : LightKind::kSoftSpot);
    soft.cos_inner = 0.9f;
    soft.cos_outer = 0.7f;
    soft.radius = 0.05f * static_cast<float>(i + 1);
  }
  add(LightKind::kDistant);
  add(LightKind::kDistant);
  lamp.table.tree = build_light_tree(lamp.table);
  return lamp;
}

Receiver some_receiver(std::mt19937& random, int i) {
  const Vec3 at = wide(random_point(random, 1.5)), n = wide(unit(random_point(random, 1)));
  return i % 3 == 0 ? Receiver(at) : Receiver(at, n);
}

TEST(LightTree, PicksAsOftenAsItSays) {
  const Lamp lamp = many_lamps();
  const std::size_t lights = lamp.table.lights.size();
  std::mt19937 places(8);
  constexpr int kReceivers = 12, kPicks = 200000;
  for (int i = 0; i < kReceivers; ++i) {
    const Receiver from = some_receiver(places, i);
    std::vector<double> observed(lights + 1), expected(lights + 1);
    Random random(static_cast<unsigned>(i));
    for (int n = 0; n < kPicks; n += kWidth) {
      const LightPick pick = pick_light(lamp.table, from, random.next(), Mask::all());
      for (int l = 0; l < kWidth; ++l) {
        const bool picked = pick.picked.bits() >> l & 1;
        ++observed[picked ? static_cast<std::size_t>(pick.light.lane(l)) : lights];
        if (picked && n < 1600) {
          const Float pmf = pick_pmf(lamp.table, pick.light, from, Mask::all());
          ASSERT_EQ(pmf.lane(l), pick.pmf.lane(l));
        }
      }
    }
    double total = 0;
    for (std::size_t light = 0; light < lights; ++light) {
      const double pmf = pick_pmf(lamp.table, Int(static_cast<int>(light)), from, Mask::all()).lane(0);
      expected[light] = pmf * kPicks;
      total += pmf;
    }
    // The rest goes to branches that turn out to reach nothing once they are looked at from nearer by.
    EXPECT_LT(total, 1 + 1e-5);
    EXPECT_GT(total, 0.6);
    expected[lights] = std::max(0.0, 1 - total) * kPicks;
    const auto result = test::chi_square_test(observed, expected);
    EXPECT_GT(result.degrees_of_freedom, 8);
    EXPECT_GT(result.p_value, test::sidak_level(0.01, kReceivers)) << "receiver " << i;
  }
}

TEST(LightTree, PicksOneOfFewTheSameForOnePointAndForMany) {
  std::mt19937 places(12);
  Random random(5);
  for (std::size_t lights = 2; lights <= kLightTreeWidth; ++lights) {
    Lamp lamp = many_lamps();
    // Lights of all kinds.
    std::shuffle(lamp.table.lights.begin(), lamp.table.lights.end(), places);
    lamp.table.lights.resize(lights);
    lamp.table.tree = build_light_tree(lamp.table);
    for (int i = 0; i < 60; ++i) {
      const Receiver from = some_receiver(places, i);
      const Float u = random.next();
      const LightPick picks = pick_light(lamp.table, from, u, Mask::all());
      const Float pmf = pick_pmf(lamp.table, picks.light, from, Mask::all());
      for (int l = 0; l < kWidth; ++l) {
        const Mask one = and_not(Mask::first(l + 1), Mask::first(l));
        const LightPick pick = pick_light(lamp.table, from, u, one);
        ASSERT_EQ(pick.picked.bits() >> l & 1, picks.picked.bits() >> l & 1);
        if (none(pick.picked & one)) continue;
        ASSERT_EQ(pick.light.lane(l), picks.light.lane(l));
        ASSERT_EQ(pick.pmf.lane(l), picks.pmf.lane(l));
        ASSERT_EQ(pick.u.lane(l), picks.u.lane(l));
        ASSERT_EQ(pick_pmf(lamp.table, pick.light, from, one).lane(l), pmf.lane(l));
      }
    }
  }
}

TEST(LightTree, FindsWhateverShines) {
  const Lamp lamp = many_lamps();
  std::mt19937 places(9);
  Random random(3);
  int shining = 0;
  for (int i = 0; i < 200; ++i) {
    const Receiver from = some_receiver(places, i);
    for (int light = 0; light < static_cast<int>(lamp.table.lights.size()); ++light) {
      const LightSample s = sample_light(lamp.table, Int(light), from, random.next_2d(), Mask::all());
      if (none(s.valid)) continue;
      ++shining;
      ASSERT_GT(pick_pmf(lamp.table, Int(light), from, Mask::all()).lane(0), 0) << "light " << light;
    }
  }
  EXPECT_GT(shining, 5000);
}

TEST(LightTree, PrefersWhatIsNearAndTurnedThisWay) {
  // Two rows of ten lamps, one shining up and one down, seen from below the first of those that shine down.
  std::vector<Point> vertices;
  std::vector<std::uint32_t> indices;
  for (std::uint32_t i = 0; i < 20; ++i) {
    const Point at{static_cast<double>(i % 10), 0, 2};
    for (const Point& p : {at, at + Point{0.1, 0, 0}, at + Point{0, 0.1, 0}}) vertices.push_back(p);
    for (const std::uint32_t k : {0u, i < 10 ? 1u : 2u, i < 10 ? 2u : 1u}) indices.push_back(3 * i + k);
  }
  Lamp lamp = mesh_lamp("rows", vertices, indices, false);
  lamp.table.tree = build_light_tree(lamp.table);
  const Receiver from(wide({0, 0, 1}), wide({0, 0, 1}));
  for (int light = 0; light < 10; ++light)
    EXPECT_EQ(pick_pmf(lamp.table, Int(light), from, Mask::all()).lane(0), 0) << light;
  const float nearest = pick_pmf(lamp.table, Int(10), from, Mask::all()).lane(0);
  EXPECT_GT(nearest, 0.4f);
  EXPECT_GT(nearest, 20 * pick_pmf(lamp.table, Int(19), from, Mask::all()).lane(0));
}

TEST(LightTree, LightsInOnePlace) {
  // Nothing tells them apart, and 32 bits must do for the way to each.
  LightRecord light;
  light.radiance[0] = 1;
  Lamp lamp;
  lamp.table.lights.assign(5000, light);
  // Each twice as bright and twice as far, so that the cheapest split takes off one at a time.
  for (std::size_t i = 0; i < 60; ++i) {
    light.position[0] = std::ldexp(1.0f, static_cast<int>(i) - 30);
    light.radiance[0] = std::ldexp(1.0f, static_cast<int>(i) - 30);
    lamp.table.lights.push_back(light);
  }
  lamp.table.tree = build_light_tree(lamp.table);
  double total = 0;
  const Receiver from(wide({3, 2, 1}));
  for (std::size_t i = 0; i < lamp.table.lights.size(); ++i)
    total += pick_pmf(lamp.table, Int(static_cast<int>(i)), from, Mask::all()).lane(0);
  EXPECT_NEAR(total, 1, 1e-5);
}

TEST(LightTree, IsEmptyWithoutLight) {
  Lamp lamp;
  EXPECT_TRUE(build_light_tree(lamp.table).empty());
  lamp.table.lights.assign(3, {});  // without power
  EXPECT_TRUE(build_light_tree(lamp.table).empty());
  EXPECT_EQ(count_bounded_lights(lamp.table), 0);
  lamp.table.lights[1].radiance[2] = 1;
  lamp.table.tree = build_light_tree(lamp.table);
  EXPECT_EQ(count_bounded_lights(lamp.table), 1);
  const LightPick pick = pick_light(lamp.table, wide({1, 1, 1}), Float(0.7f), Mask::all());
  EXPECT_TRUE(all(pick.picked));
  EXPECT_EQ(pick.light.lane(5), 1);
  EXPECT_EQ(pick.pmf.lane(5), 1);
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
