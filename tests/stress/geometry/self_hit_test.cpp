// Rays that leave a surface from the renderer's offset origins: they must not meet the surface again, nor
// slip past what touches it.
#include <limits>
#include <string>
#include <vector>

#include "render/shape/place.h"
#include "stress/geometry/closed_mesh.h"
#include "stress/geometry/traced_table.h"
#include "stress/geometry/unit_solid.h"

namespace tessera::render::TESSERA_ISA {
namespace {

Affine affine(const std::array<Point, 3>& columns, Point at) {
  Affine a;
  for (int c = 0; c < 3; ++c) {
    const Point v = columns[static_cast<std::size_t>(c)];
    a.m[c] = static_cast<float>(v.x), a.m[4 + c] = static_cast<float>(v.y),
    a.m[8 + c] = static_cast<float>(v.z);
  }
  a.m[3] = static_cast<float>(at.x), a.m[7] = static_cast<float>(at.y), a.m[11] = static_cast<float>(at.z);
  return a;
}

/// Turned, scaled by `size` and moved by `at`; `to_object`: the way back.
Affine placement(double size, Point at, bool to_object) {
  const Point x = unit({0.6, 0.64, 0.48}), y = unit(cross({0.1, -0.2, 1}, x)), z = cross(x, y);
  if (!to_object) return affine({x * size, y * size, z * size}, at);
  const Point rows[3] = {x * (1 / size), y * (1 / size), z * (1 / size)};
  return affine({Point{rows[0].x, rows[1].x, rows[2].x},
                 {rows[0].y, rows[1].y, rows[2].y},
                 {rows[0].z, rows[1].z, rows[2].z}},
                Point{-dot(rows[0], at), -dot(rows[1], at), -dot(rows[2], at)});
}

void add_quadric(ShapeTable& table, ShapeKind kind, const Affine& to, const Affine& from) {
  QuadricRecord q;
  q.render_from_object = to, q.object_from_render = from;
  ShapeRecord shape;
  shape.kind = kind;
  shape.quadric = static_cast<std::int32_t>(table.quadrics.size());
  table.quadrics.push_back(q);
  table.shapes.push_back(shape);
  table.world_shape_count = static_cast<std::int32_t>(table.shapes.size());
}

void add_mesh(ShapeTable& table, const std::vector<Point>& vertices,
              const std::vector<std::uint32_t>& triangles) {
  ShapeRecord shape;
  shape.first_vertex = static_cast<std::int32_t>(table.vertices.size());
  shape.first_triangle = static_cast<std::int32_t>(table.triangles.size() / 3);
  shape.vertex_count = static_cast<std::int32_t>(vertices.size());
  shape.triangle_count = static_cast<std::int32_t>(triangles.size() / 3);
  for (const Point p : vertices) {
    table.vertices.push_back(
        {{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)}, 0, {0, 0, 0}, 0});
  }
  table.triangles.insert(table.triangles.end(), triangles.begin(), triangles.end());
  table.shapes.push_back(shape);
  table.world_shape_count = static_cast<std::int32_t>(table.shapes.size());
}

const std::vector<std::uint32_t> kCubeTriangles = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                                   2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
std::vector<Point> cube(double size, Point at) {
  std::vector<Point> corners;
  for (int i = 0; i < 8; ++i) {
    const double x = i & 1 ? 1 : -1, y = i & 2 ? 1 : -1, z = i & 4 ? 1 : -1;
    const Affine a = placement(1, {}, false);
    corners.push_back(at + Point{a.m[0] * x + a.m[1] * y + a.m[2] * z, a.m[4] * x + a.m[5] * y + a.m[6] * z,
                                 a.m[8] * x + a.m[9] * y + a.m[10] * z} *
                               size);
  }
  return corners;
}

/// Those from kUnit on are unit_solids(), in their order.
enum class Solid {
  kSphere,
  kDisk,
  kCube,
  kRoundMesh,
  kInstancedSphere,
  kInstancedCube,
  kNestedSphere,
  kNestedCube,
  kUnit
};
std::string word_of(Solid solid) {
  constexpr const char* kNames[] = {"Sphere",          "Disk",          "Cube",         "RoundMesh",
                                    "InstancedSphere", "InstancedCube", "NestedSphere", "NestedCube"};
  const auto i = static_cast<std::size_t>(solid), first = static_cast<std::size_t>(Solid::kUnit);
  return i < first ? kNames[i] : unit_solids()[i - first].name;
}
/// All but those that are nowhere convex.
std::vector<Solid> all_solids() {
  std::vector<Solid> all;
  for (std::size_t i = 0; i < static_cast<std::size_t>(Solid::kUnit) + unit_solids().size(); ++i) {
    if (word_of(static_cast<Solid>(i)) != "CutFrustum") all.push_back(static_cast<Solid>(i));
  }
  return all;
}

/// Puts an object into four others, one within the other: maps that turn and move it far away, and back.
void nest(ShapeTable& table) {
  const Point away{3, -2, 1};
  for (std::int32_t level = 0; level < 4; ++level) {
    table.inner.push_back({placement(2, away, level % 2 != 0), placement(2, away, level % 2 == 0), level});
    table.objects.push_back({0, 0, level, 1});
  }
  table.instances[0].object = 4;
  number_places(table);
}

/// A convex solid of `size` at `at`, once; those of an instance are of size 1 within it.
ShapeTable solid_table(Solid solid, double size, Point at) {
  ShapeTable table;
  const bool nested = solid == Solid::kNestedSphere || solid == Solid::kNestedCube;
  const bool instanced = nested || solid == Solid::kInstancedSphere || solid == Solid::kInstancedCube;
  const Affine to = instanced ? Affine{} : placement(size, at, false),
               from = instanced ? Affine{} : placement(size, at, true);
  if (solid >= Solid::kUnit) {
    const auto index = static_cast<std::size_t>(solid) - static_cast<std::size_t>(Solid::kUnit);
    return table_of(unit_solids()[index], to, from);
  }
  switch (solid) {
    case Solid::kUnit:
    case Solid::kSphere:
    case Solid::kInstancedSphere:
    case Solid::kNestedSphere:
      add_quadric(table, ShapeKind::kSphere, to, from);
      break;
    case Solid::kDisk:
      add_quadric(table, ShapeKind::kDisk, to, from);
      break;
    case Solid::kCube:
      add_mesh(table, cube(size, at), kCubeTriangles);
      break;
    case Solid::kInstancedCube:
    case Solid::kNestedCube:
      add_mesh(table, cube(1, {}), kCubeTriangles);
      break;
    case Solid::kRoundMesh: {
      const ClosedMesh ball = displaced_sphere(3, 0);
      std::vector<Point> vertices;
      std::vector<std::uint32_t> triangles;
      for (const auto& p : ball.vertices) vertices.push_back(at + Point{p[0], p[1], p[2]} * size);
      for (const auto& t : ball.triangles) triangles.insert(triangles.end(), t.begin(), t.end());
      add_mesh(table, vertices, triangles);
      break;
    }
  }
  if (instanced) {
    table.objects = {{0, 1}};
    table.world_shape_count = 0;
    table.instances = {InstanceRecord{placement(size, at, false), placement(size, at, true), 0}};
  }
  if (nested) nest(table);
  return table;
}

struct SelfHits {
  std::int64_t rays = 0, bad = 0;
};

/// Whether the solid lies behind its tangent plane at a hit: not at the inner half of a torus.
bool is_convex_there(const ShapeTable& table, const Surface& s, int k) {
  if (table.shapes[0].kind != ShapeKind::kTorus) return true;
  const QuadricRecord& q = table.quadrics[0];
  const auto& m = q.object_from_render.m;
  const double p[3] = {s.p.x.lane(k), s.p.y.lane(k), s.p.z.lane(k)};
  const auto row = [&](int i) { return m[i] * p[0] + m[i + 1] * p[1] + m[i + 2] * p[2] + m[i + 3]; };
  return std::hypot(row(0), row(4)) > 1 + 1e-3 * q.inner_radius;
}

/// Rays from outside meet the solid; from there rays leave to the outer side, every other one at 10^-1 to
/// 10^-5 to it.
SelfHits leave(const ShapeTable& table, double size, Point at, std::int64_t rays) {
  const TracedTable traced(table, false);
  const ShapeKind kind = table.shapes[0].kind;
  const bool flat_solid =
      kind == ShapeKind::kDisk || kind == ShapeKind::kPolygon || kind == ShapeKind::kHalfSpace;
  Numbers random(21);
  RayBatch batch, leaving;
  SelfHits tally;
  // A thin tube is met by few.
  for (std::int64_t sent = 0; tally.rays < rays && sent < 3 * rays; sent += RayBatch::kSize) {
    for (int i = 0; i < RayBatch::kSize; ++i) {
      const Point o = at + random.direction() * (4 * size);
      batch.aim(i, o, at + random.direction() * (0.95 * size * random()));
    }
    traced.nearest(batch);
    std::array<bool, RayBatch::kSize> left{};
    for (int first = 0; first < RayBatch::kSize; first += kWidth) {
      const Surface s = traced.surface(batch, first);
      alignas(64) float w[3][kWidth];
      for (int k = 0; k < kWidth; ++k) {
        const int i = first + k;
        left[static_cast<std::size_t>(i)] = batch.shape[i] >= 0 && is_convex_there(table, s, k);
        if (batch.shape[i] < 0) {  // any ray will do
          w[0][k] = w[1][k] = 0, w[2][k] = 1;
          continue;
        }
        const Point ng = unit({s.ng.x.lane(k), s.ng.y.lane(k), s.ng.z.lane(k)});
        // The outer side: not always the one that the ray came from, which may have slipped in through an
        // edge or touch the outline.
        const Point p{s.p.x.lane(k), s.p.y.lane(k), s.p.z.lane(k)};
        const double side = (flat_solid ? -dot(ng, batch.direction(i)) : dot(ng, p - at)) > 0 ? 1 : -1;
        const Point d = random.direction();
        const Point flat = unit(d - ng * dot(d, ng));
        // Closer to the surface than floats hold directions, the side itself is rounding.
        const double cosine =
            std::max(i % 2 ? std::abs(dot(d, ng)) : std::pow(10.0, -1 - 4 * random()), 1e-5);
        const Point out = unit(flat * std::sqrt(1 - cosine * cosine) + ng * (side * cosine));
        w[0][k] = static_cast<float>(out.x), w[1][k] = static_cast<float>(out.y),
        w[2][k] = static_cast<float>(out.z);
      }
      const Vec3 out{Float::load(w[0]), Float::load(w[1]), Float::load(w[2])};
      const Vec3 origin = offset_origin(s, out);
      origin.x.store(leaving.ox + first), origin.y.store(leaving.oy + first),
          origin.z.store(leaving.oz + first);
      out.x.store(leaving.dx + first), out.y.store(leaving.dy + first), out.z.store(leaving.dz + first);
    }
    std::fill_n(leaving.distance, RayBatch::kSize, static_cast<float>(10 * size));
    traced.nearest(leaving);
    traced.shadow(leaving);
    for (int i = 0; i < RayBatch::kSize; ++i) {
      if (!left[static_cast<std::size_t>(i)]) continue;
      ++tally.rays;
      tally.bad += leaving.shape[i] >= 0 || leaving.distance[i] < 0;
    }
  }
  return tally;
}

class SelfHit : public testing::TestWithParam<Solid> {};

TEST_P(SelfHit, NoneOnConvexSolids) {
  const Solid solid = GetParam();
  for (const double size : {1e-6, 1.0, 1e9}) {
    // Farther away, rounding its vertices makes a cube or a ball hollow in places.
    for (const double distance : {0.0, 10.0, 100.0}) {
      const Point at = Point{0.6, -0.64, 0.48} * (distance * size);
      const ShapeTable table = solid_table(solid, size, at);
      const SelfHits tally = leave(table, size, at, stress_count(1e5, 1.9e6));
      EXPECT_GT(tally.rays, 0);
      EXPECT_EQ(tally.bad, 0) << "of " << tally.rays << ", size " << size << ", " << distance
                              << " sizes from the camera";
    }
  }
}

std::string solid_name(const testing::TestParamInfo<Solid>& info) { return word_of(info.param); }
INSTANTIATE_TEST_SUITE_P(All, SelfHit, testing::ValuesIn(all_solids()), solid_name);

/// Light straight above a solid that hangs a thousandth of its size above a floor: nothing of it gets to the
/// floor below.
SelfHits leak(Solid solid, double size, Point at, std::int64_t rays) {
  constexpr double kGap = 1e-3;
  const Affine turned = placement(1, {}, false);
  const Point up{turned.m[2], turned.m[6], turned.m[10]}, x{turned.m[0], turned.m[4], turned.m[8]},
      y = cross(up, x);
  // The lowest point of the solids is one size below their centre.
  ShapeTable table = solid_table(solid, size, at);
  const Point floor = at - up * ((1 + kGap) * size);
  const double half = 30 * size;
  add_mesh(table,
           {floor - x * half - y * half, floor + x * half - y * half, floor + x * half + y * half,
            floor - x * half + y * half},
           {0, 1, 2, 0, 2, 3});
  const TracedTable traced(table, false);
  Numbers random(22);
  RayBatch view, shadow;
  SelfHits tally;
  while (tally.rays < rays) {
    // Points of the floor below the solid, seen along it from the side through the gap.
    for (int i = 0; i < RayBatch::kSize; ++i) {
      const double phi = 2 * M_PI * random(), r = 0.5 * size * std::sqrt(random());
      const Point target = floor + x * (r * std::cos(phi)) + y * (r * std::sin(phi));
      // Seen from below, the floor is met, whatever stands on it.
      view.aim(i, target - up * (0.5 * size), target);
    }
    traced.nearest(view);
    for (int first = 0; first < RayBatch::kSize; first += kWidth) {
      const Surface s = traced.surface(view, first);
      const Point lamp = at + up * (20 * size);
      const Vec3 to_lamp = Vec3{Float(static_cast<float>(lamp.x)), Float(static_cast<float>(lamp.y)),
                                Float(static_cast<float>(lamp.z))} -
                           s.p;
      const Vec3 w = normalize(to_lamp);
      const Vec3 origin = offset_origin(s, w);
      origin.x.store(shadow.ox + first), origin.y.store(shadow.oy + first), origin.z.store(shadow.oz + first);
      w.x.store(shadow.dx + first), w.y.store(shadow.dy + first), w.z.store(shadow.dz + first);
      length(to_lamp).store(shadow.distance + first);
    }
    traced.shadow(shadow);
    for (int i = 0; i < RayBatch::kSize; ++i) {
      if (view.shape[i] != static_cast<std::int32_t>(table.shapes.size()) - 1) continue;
      ++tally.rays;
      tally.bad += !(shadow.distance[i] < 0);
    }
  }
  return tally;
}

TEST(ContactShadow, LetsNoLightThrough) {
  for (const Solid solid : {Solid::kSphere, Solid::kCube, Solid::kRoundMesh}) {
    for (const double size : {1e-6, 1.0, 1e9}) {
      for (const double distance : {0.0, 10.0, 100.0}) {
        const Point at = Point{0.6, -0.64, 0.48} * (distance * size);
        const SelfHits tally = leak(solid, size, at, stress_count(1e5, 5e5));
        EXPECT_EQ(tally.bad, 0) << word_of(solid) << ", size " << size << ", " << distance
                                << " sizes from the camera";
      }
    }
  }
}

/// Products of four lengths are beyond floats from 10^-10 and 10^10 on; Embree's own, of three, from 10^-12
/// and 10^12.
TEST(TriangleNormals, AreRightAtAnySize) {
  for (const double size : {1e-12, 1e-11, 1e-9, 1.0, 1e9, 1e11, 1e12}) {
    SCOPED_TRACE(testing::Message() << "size " << size);
    const Point a = Point{0.3, 0.1, 3} * size, b = Point{1.1, 0.2, 3.3} * size,
                c = Point{0.2, 0.9, 2.8} * size, n = unit(cross(b - a, c - a));
    ShapeTable table;
    add_mesh(table, {a, b, c}, {0, 1, 2});
    const TracedTable traced(table, false);
    RayBatch batch;
    for (int i = 0; i < RayBatch::kSize; ++i) {
      const double u = 0.05 + 0.4 * i / RayBatch::kSize, v = 0.5 - u;
      batch.aim(i, {}, a + (b - a) * u + (c - a) * v);
    }
    traced.nearest(batch);
    for (int first = 0; first < RayBatch::kSize; first += kWidth) {
      const Surface s = traced.surface(batch, first);
      for (int k = 0; k < kWidth; ++k) {
        ASSERT_GE(batch.shape[first + k], 0);
        // Vertices are off by 2^-24 of 3.3 sizes, sides are as short as 0.8.
        ASSERT_LT(length(Point{s.ng.x.lane(k), s.ng.y.lane(k), s.ng.z.lane(k)} - n), 2e-6);
      }
    }
  }
}

/// A ray through the middle meets them.
std::vector<Solid> solids_in_the_middle() {
  std::vector<Solid> solids = all_solids();
  std::erase_if(solids, [](Solid solid) { return word_of(solid).ends_with("Torus"); });
  return solids;
}

class UnsoundRays : public testing::TestWithParam<Solid> {};

TEST_P(UnsoundRays, MeetNothingAndAreBlocked) {
  const ShapeTable table = solid_table(GetParam(), 1, {});
  const TracedTable traced(table, false);
  const float bad[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                       -std::numeric_limits<float>::infinity(), 2e18f};
  RayBatch batch;
  const auto fill = [&] {
    for (int i = 0; i < RayBatch::kSize; ++i) {
      batch.set(i, {0, 0, -3}, {0, 0, 1});
      batch.distance[i] = 1;
      float* const coordinates[] = {batch.ox, batch.oy, batch.oz, batch.dx, batch.dy, batch.dz};
      if (i % 2) coordinates[i / 2 % 6][i] = bad[i / 12 % 4];
    }
  };
  for (const Traversal traversal : {Traversal::kIncoherent, Traversal::kCoherent, Traversal::kSingle}) {
    fill();
    traced.nearest(batch, RayBatch::kSize, traversal);
    for (int i = 0; i < RayBatch::kSize; ++i) ASSERT_EQ(batch.shape[i], i % 2 ? -1 : 0) << i;
    traced.shadow(batch, RayBatch::kSize, traversal);
    for (int i = 0; i < RayBatch::kSize; ++i) ASSERT_EQ(batch.distance[i] < 0, i % 2 == 1) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(All, UnsoundRays, testing::ValuesIn(solids_in_the_middle()), solid_name);

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
