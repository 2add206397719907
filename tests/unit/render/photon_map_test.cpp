#include "render/transport/photon_map/photon_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <vector>

#include "render/transport/photon_map/photon.h"

namespace tessera::render::TESSERA_ISA {
namespace photon_map {

/// A photon of an algorithm that has more to carry than others.
template <class Form>
struct alignas(64) NamedPhotonFields {
  typename Form::Vector position;
  typename Form::Integer name;
  typename Form::Scalar weight;

  template <class F, class... Photons>
  static void for_each(F&& f, Photons&... photons) {
    f(photons.position...);
    f(photons.name...);
    f(photons.weight...);
  }
};

namespace {

using Map = PhotonMap<NamedPhotonFields>;

struct Dot {
  float x, y, z;
};

/// The points in packets of 16, under their numbers.
Map map_of(const std::vector<Dot>& points, float radius) {
  Map map;
  for (std::size_t first = 0; first < points.size(); first += kWidth) {
    alignas(64) float x[kWidth] = {}, y[kWidth] = {}, z[kWidth] = {};
    const int n = static_cast<int>(std::min<std::size_t>(kWidth, points.size() - first));
    for (int i = 0; i < n; ++i) {
      const Dot& p = points[first + static_cast<std::size_t>(i)];
      x[i] = p.x, y[i] = p.y, z[i] = p.z;
    }
    const Int name = Int::iota(static_cast<std::int32_t>(first));
    map.append({{Float::load(x), Float::load(y), Float::load(z)}, name, to_float(name) * 0.5f},
               Mask::first(n));
  }
  map.build(radius);
  return map;
}

std::vector<std::int32_t> lanes_of(Int value, Mask active) {
  alignas(64) std::int32_t packed[2 * kWidth];
  const int n = compress_store(value, active, packed);
  return {packed, packed + n};
}

/// Names of the photons that a query gives, in ascending order; a name that is given twice is there twice.
std::multiset<std::int32_t> near(const Map& map, const Dot& p) {
  std::multiset<std::int32_t> names;
  map.for_each_near(p.x, p.y, p.z, [&](std::int32_t first, Mask found, Float) {
    const Map::Wide photons = map.load(first);
    for (const std::int32_t name : lanes_of(photons.name, found)) names.insert(name);
    // The fields of a photon come with it.
    EXPECT_TRUE(none(found & (photons.weight != to_float(photons.name) * 0.5f)));
  });
  return names;
}

/// The same by looking at all, with the map's arithmetic.
std::multiset<std::int32_t> near_by_brute_force(const std::vector<Dot>& points, const Dot& p, float radius) {
  std::multiset<std::int32_t> names;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float dx = points[i].x - p.x, dy = points[i].y - p.y, dz = points[i].z - p.z;
    if (std::fma(dx, dx, std::fma(dy, dy, dz * dz)) < radius * radius)
      names.insert(static_cast<std::int32_t>(i));
  }
  return names;
}

/// Points in a box, on two of its sides, and on a lattice of cells' corners, `scale` being the box's side.
std::vector<Dot> scattered_points(std::size_t n, float scale, float radius, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-0.5f, 0.5f);
  std::vector<Dot> points;
  for (std::size_t i = 0; i < n; ++i) {
    const float x = scale * uniform(random), y = scale * uniform(random), z = scale * uniform(random);
    switch (i % 4) {
      case 0:
        points.push_back({x, y, z});
        break;
      case 1:
        points.push_back({x, 0.25f * scale, z});
        break;
      case 2:
        points.push_back({0.0f, y, z});
        break;
      default:
        points.push_back({2 * radius * std::round(x / (2 * radius)),
                          2 * radius * std::round(y / (2 * radius)),
                          2 * radius * std::round(z / (2 * radius))});
    }
  }
  return points;
}

TEST(PhotonMap, FindsWhatLookingAtAllFinds) {
  struct Case {
    std::size_t points;
    float scale, radius;
  };
  // From a handful to many, from queries of one photon to those of most, far from the origin or not.
  for (const Case& c :
       {Case{1, 1, 0.1f}, Case{15, 1, 0.5f}, Case{333, 1, 0.05f}, Case{5000, 1, 0.02f}, Case{5000, 1, 1.5f},
        Case{5000, 1e6f, 1.0f}, Case{5000, 1e-6f, 1e-8f}, Case{5000, 1e30f, 1e17f}}) {
    const std::vector<Dot> points = scattered_points(c.points, c.scale, c.radius, 7);
    const Map map = map_of(points, c.radius);
    ASSERT_EQ(map.size(), static_cast<std::int32_t>(c.points));
    std::vector<Dot> places = scattered_points(200, c.scale, c.radius, 8);
    // At photons themselves, and just about a radius away.
    for (std::size_t i = 0; i < std::min<std::size_t>(points.size(), 100); ++i) {
      const Dot& p = points[i];
      places.push_back(p);
      places.push_back({p.x + c.radius, p.y, p.z});
      places.push_back({p.x, std::nextafter(p.y - c.radius, p.y), p.z});
      places.push_back({p.x, p.y, std::nextafter(p.z + c.radius, p.z)});
    }
    for (const Dot& p : places) {
      ASSERT_EQ(near(map, p), near_by_brute_force(points, p, c.radius))
          << p.x << " " << p.y << " " << p.z << " of " << c.points << " in " << c.scale;
    }
  }
}

TEST(PhotonMap, SixteenPlacesAtOnceFindTheSame) {
  const float radius = 0.3f;
  // Some places have hundreds of photons, more than are looked at in one go, others none.
  const std::vector<Dot> points = scattered_points(20000, 4, radius, 3);
  const Map map = map_of(points, radius);
  for (std::uint32_t seed = 0; seed < 8; ++seed) {
    const std::vector<Dot> places = scattered_points(kWidth, 6, radius, 100 + seed);
    alignas(64) float x[kWidth], y[kWidth], z[kWidth];
    for (std::size_t i = 0; i < kWidth; ++i) x[i] = places[i].x, y[i] = places[i].y, z[i] = places[i].z;
    const Mask active = Mask::from_bits(seed == 0 ? 0xffffu : 0x35a7u << seed % 3);
    std::multiset<std::int32_t> found[kWidth];
    map.for_each_near({Float::load(x), Float::load(y), Float::load(z)}, active,
                      [&](const Map::Wide& photons, Mask near) {
                        for (std::uint32_t left = near.bits(); left != 0; left &= left - 1) {
                          const int lane = std::countr_zero(left);
                          found[lane].insert(photons.name.lane(lane));
                        }
                      });
    for (std::size_t i = 0; i < kWidth; ++i) {
      const bool asked = (active.bits() >> i & 1) != 0;
      EXPECT_EQ(found[i],
                asked ? near_by_brute_force(points, places[i], radius) : std::multiset<std::int32_t>{})
          << i;
    }
  }
}

TEST(PhotonMap, HasNothingWhereThereIsNothing) {
  Map map;
  EXPECT_TRUE(near(map, {0, 0, 0}).empty()) << "never built";
  map.build(1);
  EXPECT_TRUE(near(map, {0, 0, 0}).empty());
  map = map_of({{0, 0, 0}}, 1);
  EXPECT_EQ(near(map, {0, 0, 0.5f}).size(), 1u);
  map.clear();
  map.build(1);
  EXPECT_EQ(map.size(), 0);
  EXPECT_TRUE(near(map, {0, 0, 0.5f}).empty());
  // A query of no size, and a place that is none.
  EXPECT_TRUE(near(map_of({{1, 2, 3}}, 0), {1, 2, 3}).empty());
  EXPECT_TRUE(near(map_of({{1, 2, 3}}, 1), {std::nanf(""), 2, 3}).empty());
}

TEST(PhotonMap, HoldsManyPhotonsInOnePoint) {
  const std::vector<Dot> points(10000, {-3, 5, 0.1f});
  const Map map = map_of(points, 1e-3f);
  EXPECT_EQ(near(map, {-3, 5, 0.1f}), near_by_brute_force(points, {-3, 5, 0.1f}, 1e-3f));
  EXPECT_EQ(near(map, {-3, 5, 0.1f}).size(), points.size());
  EXPECT_TRUE(near(map, {-3, 5, 0.2f}).empty());
  std::size_t met = 0;
  map.for_each_near({Float(-3.0f), Float(5.0f), Float(0.1f)}, Mask::all(),
                    [&](const Map::Wide&, Mask near) { met += static_cast<std::size_t>(count(near)); });
  EXPECT_EQ(met, kWidth * points.size());
}

TEST(PhotonMap, DropsPhotonsThatAreNowhere) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const Map map = map_of({{nan, 0, 0}, {0, 0, 0}, {0, inf, 0}, {0, 0, -inf}, {0.5f, 0, 0}}, 1);
  EXPECT_EQ(map.size(), 2);
  EXPECT_EQ(near(map, {0, 0, 0}), (std::multiset<std::int32_t>{1, 4}));
}

TEST(PhotonMap, KeepsThoseThatAFilterKeeps) {
  Map map;
  const std::vector<Dot> points = scattered_points(1000, 1, 0.1f, 5);
  map = map_of(points, 0.1f);
  map.clear();
  for (std::int32_t first = 0; first < 1000; first += kWidth) {
    const Int name = Int::iota(first);
    map.append({{to_float(name), Float(0.0f), Float(0.0f)}, name, to_float(name) * 0.5f},
               Mask::first(1000 - first));
  }
  map.filter([](Int entries) { return (entries & 3) == 1; });
  EXPECT_EQ(map.size(), 250);
  map.build(10.5f);
  std::multiset<std::int32_t> expected;
  for (std::int32_t name = 493; name <= 510; ++name) {
    if (name % 4 == 1 && std::abs(name - 500) <= 10) expected.insert(name);
  }
  EXPECT_EQ(near(map, {500, 0, 0}), expected);
}

TEST(PhotonMap, MeetsPhotonsOfACellInTheOrderInWhichTheyCame) {
  // Sums over photons are thereby the same, whatever else is in the map.
  const std::vector<Dot> points(100, {1, 1, 1});
  std::vector<std::int32_t> names;
  const Map map = map_of(points, 0.5f);
  map.for_each_near(1, 1, 1, [&](std::int32_t first, Mask found, Float) {
    for (const std::int32_t name : lanes_of(map.load(first).name, found)) names.push_back(name);
  });
  ASSERT_EQ(names.size(), points.size());
  EXPECT_TRUE(std::is_sorted(names.begin(), names.end()));
}

TEST(PhotonMap, TellsItsMemory) {
  // Five columns, two to sort into, and what the table has a photon: no more than said, and no less than the
  // columns alone.
  EXPECT_GE(Map::memory_bytes(1000), 1000 * 4 * 5u);
  EXPECT_LE(Map::memory_bytes(1000), 1000 * 4 * (5 + 6u));
}

}  // namespace
}  // namespace photon_map
}  // namespace tessera::render::TESSERA_ISA
