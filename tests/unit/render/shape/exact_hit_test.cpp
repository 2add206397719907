// Where a hit lies in its triangle does not depend on how Embree rounded it.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>

#include "render/shape/surface.h"
#include "support/kernel/double_point.h"

namespace tessera::render::TESSERA_ISA {
namespace {

using test::Point;

Vec3 wide(Point p) {
  return {Float(static_cast<float>(p.x)), Float(static_cast<float>(p.y)), Float(static_cast<float>(p.z))};
}

ShapeTable table_of(const Point (&corners)[3]) {
  ShapeTable table;
  ShapeRecord& shape = table.shapes.emplace_back();
  shape.triangle_count = 1, shape.vertex_count = 3;
  for (const Point& corner : corners) {
    Vertex& v = table.vertices.emplace_back();
    v.position[0] = static_cast<float>(corner.x);
    v.position[1] = static_cast<float>(corner.y);
    v.position[2] = static_cast<float>(corner.z);
  }
  table.triangles = {0, 1, 2};
  // Rows are read in fours.
  table.vertices.resize(8), table.triangles.resize(16);
  return table;
}

Surface surface(const ShapeTable& table, double u, double v, Vec3 o, Vec3 d) {
  const Hit hit{Float(1.0f), Float(static_cast<float>(u)), Float(static_cast<float>(v)), Int(0), Int(0),
                Int(-1)};
  return surface_at(table, hit, o, d, Mask::all(), true);
}

Point position(const Surface& s) { return {s.p.x.lane(0), s.p.y.lane(0), s.p.z.lane(0)}; }

bool same_bits(Vec3 a, Vec3 b) {
  const auto bits = [](Float f) { return std::bit_cast<std::uint32_t>(f.lane(0)); };
  return bits(a.x) == bits(b.x) && bits(a.y) == bits(b.y) && bits(a.z) == bits(b.z);
}

TEST(ExactHit, HasTheSameBitsHoweverItsWeightsWereRounded) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0.0, 1.0), about(-1.0, 1.0);
  const auto point = [&] { return Point{about(random), about(random), about(random)}; };
  for (int i = 0; i < 1000; ++i) {
    const Point corners[3] = {point(), point(), point()};
    const ShapeTable table = table_of(corners);
    const double u = unit(random), v = unit(random) * (1 - u);
    const Point target = corners[0] * (1 - u - v) + corners[1] * u + corners[2] * v, from = point() * 5;
    const Point to = target - from;
    const Vec3 o = wide(from), d = wide(to * (1 / length(to)));
    // 2^-20 and more is what a reciprocal of 12 bits and a Newton step leave, twice over.
    const Surface a = surface(table, u * (1 + 0x1p-20), v * (1 - 0x1p-21), o, d);
    const Surface b = surface(table, u * (1 - 0x1p-22), v * (1 + 0x1p-20), o, d);
    EXPECT_TRUE(
        same_bits(a.p, b.p) && same_bits({a.uv.x, a.uv.y, a.error}, {b.uv.x, b.uv.y, b.error}) &&
        same_bits({a.barycentric.x, a.barycentric.y, a.error}, {b.barycentric.x, b.barycentric.y, b.error}))
        << i;
    // The ray itself is rounded: its direction by 2^-24 a coordinate over a way of at most 7, where it meets
    // the triangle at an angle whose sine is `steep`.
    const Vec3 n = a.ng;
    const double steep = std::abs(dot(d, n).lane(0));
    EXPECT_LT(length(position(a) - target), 7 * 0x1p-21 / steep + 0x1p-20) << i;
  }
}

TEST(ExactHit, LiesOnTheTriangle) {
  const Point corners[3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const ShapeTable table = table_of(corners);
  // A ray that passes the edge by as much as Embree's own test may be off.
  const Surface beyond = surface(table, 0.5, 0.5, wide({0.5 + 1e-6, 0.5, 1}), wide({0, 0, -1}));
  EXPECT_LE(position(beyond).x + position(beyond).y, 1 + 1e-7);
  const Surface before = surface(table, 0, 0.5, wide({-1e-6, 0.5, 1}), wide({0, 0, -1}));
  EXPECT_GE(position(before).x, 0.0);
}

TEST(ExactHit, KeepsEmbreesWeightsWhereTheRayTellsNothing) {
  const Point corners[3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const ShapeTable table = table_of(corners);
  // A ray in the plane; a point that a light is looked up at, which has no ray.
  for (const Point direction : {Point{1, 0, 0}, Point{0, 0, 0}}) {
    const Point p = position(surface(table, 0.25, 0.5, wide({-1, 0.5, 0}), wide(direction)));
    EXPECT_EQ(p.x, 0.25);
    EXPECT_EQ(p.y, 0.5);
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
