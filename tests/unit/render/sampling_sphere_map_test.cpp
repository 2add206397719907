#include "render/sampling/sphere_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "render/sampling/warp.h"

namespace tessera::render::TESSERA_ISA {
namespace {

Vec3 direction(float x, float y, float z) { return normalize({Float(x), Float(y), Float(z)}); }

void expect_near(Vec3 a, Vec3 b, float tolerance) {
  EXPECT_NEAR(a.x.lane(0), b.x.lane(0), tolerance);
  EXPECT_NEAR(a.y.lane(0), b.y.lane(0), tolerance);
  EXPECT_NEAR(a.z.lane(0), b.z.lane(0), tolerance);
}

Vec2 at(float u, float v) { return {Float(u), Float(v)}; }

TEST(OctahedralMap, HasItsLandmarks) {
  // pbrt-v4's map: the centre is +z, the corners -z, the middles of the edges the horizon.
  expect_near(direction_from_octahedral(at(0.5f, 0.5f)), direction(0, 0, 1), 1e-6f);
  for (const float u : {0.0f, 1.0f}) {
    for (const float v : {0.0f, 1.0f})
      expect_near(direction_from_octahedral(at(u, v)), direction(0, 0, -1), 1e-6f);
  }
  expect_near(direction_from_octahedral(at(1, 0.5f)), direction(1, 0, 0), 1e-6f);
  expect_near(direction_from_octahedral(at(0, 0.5f)), direction(-1, 0, 0), 1e-6f);
  expect_near(direction_from_octahedral(at(0.5f, 1)), direction(0, 1, 0), 1e-6f);
  expect_near(direction_from_octahedral(at(0.5f, 0)), direction(0, -1, 0), 1e-6f);
  // Half-way to the edge: r = 1/2, z = 1 - r^2.
  expect_near(direction_from_octahedral(at(0.75f, 0.5f)),
              {Float(std::sqrt(1 - 0.5625f)), Float(0.0f), Float(0.75f)}, 1e-6f);
}

TEST(OctahedralMap, KeepsAreas) {
  // The share of a grid's midpoints within a cap is the cap's share of the sphere, to the border's share of
  // cells.
  constexpr int kN = 256;
  const Vec3 axis = direction(0.3f, -0.5f, -0.7f);
  int inside = 0;
  for (int y = 0; y < kN; ++y) {
    for (int x = 0; x < kN; x += kWidth) {
      const Vec3 w = direction_from_octahedral(
          {(to_float(Int::iota(x)) + 0.5f) * (1.0f / kN), Float((static_cast<float>(y) + 0.5f) / kN)});
      inside += count(dot(w, axis) > 0.5f);
    }
  }
  EXPECT_NEAR(inside / double(kN * kN), 0.25, 2.0 / kN);
}

TEST(LatLongMap, HasItsLandmarks) {
  // Mitsuba 3's map: +y on top, the edges at -z, then +x, +z, -x.
  expect_near(direction_from_latlong(at(0.3f, 0)), direction(0, 1, 0), 1e-6f);
  expect_near(direction_from_latlong(at(0, 0.5f)), direction(0, 0, -1), 1e-6f);
  expect_near(direction_from_latlong(at(0.25f, 0.5f)), direction(1, 0, 0), 1e-6f);
  expect_near(direction_from_latlong(at(0.5f, 0.5f)), direction(0, 0, 1), 1e-6f);
  expect_near(direction_from_latlong(at(0.75f, 0.5f)), direction(-1, 0, 0), 1e-6f);
  for (const float y : {1.0f, -1.0f}) {
    const LatLong pole = latlong_from_direction(direction(0, y, 0));
    EXPECT_NEAR(pole.uv.y.lane(0), y > 0 ? 0 : 1, 1e-6);
    EXPECT_TRUE(pole.uv.x.lane(0) >= 0 && pole.uv.x.lane(0) <= 1);
  }
}

TEST(EnvironmentMaps, RoundTrip) {
  std::mt19937 random(1);
  const auto next = [&] {
    alignas(64) float u[kWidth];
    for (float& x : u) x = static_cast<float>(random() >> 8) * 0x1p-24f;
    return Float::load(u);
  };
  for (int i = 0; i < 1000; ++i) {
    // Every other batch crowds around the poles of the maps, where digits are lost if anywhere.
    Vec3 w = square_to_sphere({next(), next()});
    if (i % 2 == 1)
      w = normalize(i % 4 == 1 ? Vec3{w.x * 1e-4f, w.y * 1e-4f, w.z} : Vec3{w.x * 1e-4f, w.y, w.z * 1e-4f});
    for (const Vec3& back : {direction_from_octahedral(octahedral_from_direction(w)),
                             direction_from_latlong(latlong_from_direction(w).uv)}) {
      // A float in [0, 1] places a direction to 2^-24 * 2 pi; several roundings.
      ASSERT_LT(reduce_max(length(back - w)), 2e-6f);
    }
    const Vec2 uv = octahedral_from_direction(w);
    ASSERT_TRUE(all((uv.x >= 0.0f) & (uv.x <= 1.0f) & (uv.y >= 0.0f) & (uv.y <= 1.0f)));
  }
  for (const Vec3& w : {direction(1, 0, 0), direction(0, 1, 0), direction(0, 0, 1), direction(-1, 0, 0),
                        direction(0, -1, 0), direction(0, 0, -1), direction(1, 1, 0), direction(-1, 0, 1)}) {
    expect_near(direction_from_octahedral(octahedral_from_direction(w)), w, 2e-6f);
    expect_near(direction_from_latlong(latlong_from_direction(w).uv), w, 2e-6f);
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
