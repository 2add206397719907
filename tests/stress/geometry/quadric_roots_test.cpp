// Roots of spheres, disks and cylinders against arithmetic of 113 bits, which holds all that floats give
// exactly but the square roots.
#include <string>
#include <tuple>

#include "stress/geometry/quad_arithmetic.h"
#include "stress/geometry/traced_table.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// Whether `p` is inside the limits; clears `certain` within 32 roundings of one.
bool inside(const QuadricRecord& q, ShapeKind kind, const QuadPoint& p, bool& certain) {
  bool in = true;
  const auto at_least = [&](double x, double limit, double scale) {
    certain = certain && std::abs(x - limit) > 32 * kUnit * scale;
    in = in && x >= limit;
  };
  const double x = static_cast<double>(p.x), y = static_cast<double>(p.y), z = static_cast<double>(p.z);
  if (kind == ShapeKind::kDisk) {
    const double r = std::hypot(x, y);
    at_least(q.radius, r, q.radius);
    if (q.inner_radius > 0) at_least(r, q.inner_radius, q.radius);
  }
  if (kind == ShapeKind::kCylinder || (kind == ShapeKind::kSphere && q.z_min > -q.radius))
    at_least(z, q.z_min, q.radius);
  if (kind == ShapeKind::kCylinder || (kind == ShapeKind::kSphere && q.z_max < q.radius))
    at_least(q.z_max, z, q.radius);
  if (q.phi_max < 6.28f) {
    double phi = std::atan2(y, x);
    if (phi < 0) phi += 2 * M_PI;
    // The kernels' arc tangent is right to 1e-6; near the axis the point's own rounding counts.
    const double off = 2e-6 + 32 * kUnit * q.radius / std::max(std::hypot(x, y), 1e-30);
    certain = certain && std::abs(phi - q.phi_max) > off && phi > off && phi < 2 * M_PI - off;
    in = in && phi <= q.phi_max;
  }
  return in;
}

Expected expected(const QuadricRecord& q, ShapeKind kind, Point origin, Point direction) {
  const QuadPoint o = placed(q.object_from_render, origin, 1), d = placed(q.object_from_render, direction, 0);
  const Quad r = q.radius;
  Expected e;
  const auto consider = [&](Quad t, double slack) {
    if (e.hit) return;
    const double off = 2 * kUnit * magnitude(t) + slack;
    e.certain = e.certain && magnitude(t) > off;
    if (t <= 0 || !inside(q, kind, along(o, d, t), e.certain)) return;
    e.hit = true, e.t = static_cast<double>(t), e.tolerance = off;
  };
  if (kind == ShapeKind::kDisk) {
    if (d.z == 0) return e;
    consider((Quad(q.height) - o.z) / d.z, 4 * kUnit * magnitude(r / d.z));
    return e;
  }
  const int dz = kind == ShapeKind::kSphere;
  const Quad a = d.x * d.x + d.y * d.y + dz * d.z * d.z;
  if (a == 0) return e;
  const Quad middle = -(o.x * d.x + o.y * d.y + dz * o.z * d.z) / a;
  const QuadPoint n = along(o, d, middle);
  const Quad discriminant = r * r - (n.x * n.x + n.y * n.y + dz * n.z * n.z);
  e.certain = magnitude(discriminant) > 16 * kUnit * magnitude(r * r);
  if (discriminant < 0) return e;
  // The squares of radius and distance are off by a few roundings of the radius squared; so is the half
  // chord's square.
  const Quad half_chord = root(discriminant / a);
  const double slack = 8 * kUnit * magnitude(r * r / (a * half_chord + Quad(1e-300)));
  consider(middle - half_chord, slack);
  consider(middle + half_chord, slack);
  return e;
}

/// Turned, of `size`, at `at`.
ShapeTable quadric_table(ShapeKind kind, bool cut, double size, Point at) {
  const Point x = unit({0.6, 0.64, 0.48}), y = unit(cross({0.1, -0.2, 1}, x)), z = cross(x, y);
  QuadricRecord q;
  int row = 0;
  for (const Point axis : {x, y, z}) {  // rows of the inverse: columns of the map over size squared
    const double a[3] = {axis.x, axis.y, axis.z};
    for (int i = 0; i < 3; ++i) {
      q.object_from_render.m[4 * row + i] = static_cast<float>(a[i] / size);
      q.render_from_object.m[4 * i + row] = static_cast<float>(a[i] * size);
    }
    q.object_from_render.m[4 * row + 3] = static_cast<float>(-dot(axis, at) / size);
    ++row;
  }
  q.render_from_object.m[3] = static_cast<float>(at.x);
  q.render_from_object.m[7] = static_cast<float>(at.y);
  q.render_from_object.m[11] = static_cast<float>(at.z);
  if (cut) {
    q.partial = 1;
    q.phi_max = 4.2f;
    if (kind == ShapeKind::kSphere) q.z_min = -0.6f, q.z_max = 0.85f;
    if (kind == ShapeKind::kDisk) q.inner_radius = 0.35f;
  }
  ShapeTable table;
  table.quadrics = {q};
  ShapeRecord shape;
  shape.kind = kind;
  table.shapes = {shape};
  table.world_shape_count = 1;
  return table;
}

struct Tally {
  std::int64_t rays = 0, hits = 0, uncertain = 0, wrong = 0, off = 0;
  double worst = 0;  // error over tolerance
};

/// Rays to points about the quadric from `distance` away: through it, and past its outline by little.
Tally compare(const ShapeTable& table, Point at, double size, double distance, bool from_camera,
              std::int64_t rays) {
  const TracedTable traced(table, false);
  const QuadricRecord& q = table.quadrics[0];
  const ShapeKind kind = table.shapes[0].kind;
  Numbers random(11);
  RayBatch batch;
  Tally tally;
  for (; tally.rays < rays; tally.rays += RayBatch::kSize) {
    for (int i = 0; i < RayBatch::kSize; ++i) {
      const Point o = from_camera ? Point{} : at + random.direction() * (distance * size);
      const Point view = unit(at - o), side = unit(cross(view, random.direction()));
      // Even over the disk of the outline for half of them; the others are close to it, at 1 +- 10^-1 ..
      // 10^-7.
      const double near_outline = std::pow(10.0, -1 - 6 * random()) * (random() < 0.5 ? 1 : -1);
      const double r = i % 2 ? std::sqrt(random()) : 1 + near_outline;
      // The tangent touches a sphere at its outline: short of the plane through the centre.
      const double shrink = std::sqrt(std::max(0.0, 1 - 1 / (distance * distance)));
      batch.aim(i, o, at + side * (r * size / std::max(shrink, 0.1)));
    }
    traced.nearest(batch);
    for (int i = 0; i < RayBatch::kSize; ++i) {
      const Expected e = expected(q, kind, batch.origin(i), batch.direction(i));
      tally.hits += e.hit;
      tally.uncertain += !e.certain;
      if (!e.certain) continue;
      const bool hit = batch.shape[i] >= 0;
      tally.wrong += hit != e.hit;
      if (!hit || !e.hit) continue;
      const double error = std::abs(batch.t[i] - e.t) / e.tolerance;
      tally.off += error > 1;
      tally.worst = std::max(tally.worst, error);
    }
  }
  return tally;
}

class QuadricRoots : public testing::TestWithParam<std::tuple<ShapeKind, bool>> {};

TEST_P(QuadricRoots, AreThoseOfExactArithmetic) {
  const auto [kind, cut] = GetParam();
  for (const double size : {1e-6, 1.0, 1e9}) {
    for (const double distance : {1.5, 1e3, 1e6}) {
      for (const bool from_camera : {true, false}) {
        const Point at = from_camera ? unit({0.3, -0.7, 0.65}) * (distance * size) : Point{};
        const ShapeTable table = quadric_table(kind, cut, size, at);
        const Tally tally = compare(table, at, size, distance, from_camera, stress_count(2.5e4, 1.5e5));
        SCOPED_TRACE(testing::Message()
                     << "size " << size << ", distance " << distance
                     << (from_camera ? ", from the camera: " : ": ") << tally.wrong << " wrong of "
                     << tally.rays << ", " << tally.off << " off, worst " << tally.worst);
        EXPECT_EQ(tally.wrong, 0);
        EXPECT_EQ(tally.off, 0);
        EXPECT_GT(tally.hits, tally.rays / 20);
        // Within 16 to 32 roundings of a decision: of rays that approach the outline by up to 1e-7, evenly in
        // its logarithm.
        EXPECT_LT(tally.uncertain, tally.rays / 5);
      }
    }
  }
}

std::string name_of(const testing::TestParamInfo<std::tuple<ShapeKind, bool>>& info) {
  const char* names[] = {"Triangles", "Sphere", "Disk", "Cylinder"};
  return std::string(names[static_cast<int>(std::get<0>(info.param))]) +
         (std::get<1>(info.param) ? "Cut" : "Whole");
}
INSTANTIATE_TEST_SUITE_P(All, QuadricRoots,
                         testing::Combine(testing::Values(ShapeKind::kSphere, ShapeKind::kDisk,
                                                          ShapeKind::kCylinder),
                                          testing::Bool()),
                         name_of);

/// Through the middle half of the outline nothing is close to a decision: every ray must hit.
TEST(QuadricHits, NoneIsMissed) {
  std::int64_t rays = 0, missed = 0;
  for (const double distance : {2.0, 1e3, 1e6}) {
    const Point at = unit({0.3, -0.7, 0.65}) * distance;
    const ShapeTable table = quadric_table(ShapeKind::kSphere, false, 1, at);
    const TracedTable traced(table, false);
    Numbers random(12);
    RayBatch batch;
    const std::int64_t wanted = stress_count(1e6, 4e6);
    for (std::int64_t n = 0; n < wanted; n += RayBatch::kSize) {
      for (int i = 0; i < RayBatch::kSize; ++i) batch.aim(i, {}, at + random.direction() * 0.5);
      traced.nearest(batch);
      for (int i = 0; i < RayBatch::kSize; ++i) missed += batch.shape[i] < 0;
      rays += RayBatch::kSize;
    }
  }
  EXPECT_EQ(missed, 0) << "of " << rays;
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
