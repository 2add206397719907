// Cylinders and grids of distances: what rays meet, and the surface there, against closed forms.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "render/accel/embree/accelerator.h"
#include "render/accel/embree/trace.h"
#include "render/color/texture_table.h"
#include "render/shape/surface.h"
#include "support/kernel/double_point.h"

#define TESSERA_STRING2(x) #x
#define TESSERA_STRING(x) TESSERA_STRING2(x)

namespace tessera::render::TESSERA_ISA {
namespace {

using test::Point;

Point lane(Vec3 v, int i) { return {v.x.lane(i), v.y.lane(i), v.z.lane(i)}; }

/// 16 rays against the first shape of a table.
struct Rays {
  alignas(64) float ox[kWidth], oy[kWidth], oz[kWidth], dx[kWidth], dy[kWidth], dz[kWidth];
  alignas(64) float t[kWidth], u[kWidth], v[kWidth];
  alignas(64) std::int32_t primitive[kWidth], shape[kWidth], instance[kWidth];

  void set(int i, Point o, Point d) {
    const Point n = d * (1 / length(d));
    ox[i] = static_cast<float>(o.x), oy[i] = static_cast<float>(o.y), oz[i] = static_cast<float>(o.z);
    dx[i] = static_cast<float>(n.x), dy[i] = static_cast<float>(n.y), dz[i] = static_cast<float>(n.z);
  }
  Point origin(int i) const { return {ox[i], oy[i], oz[i]}; }
  Point direction(int i) const { return {dx[i], dy[i], dz[i]}; }
};

class Traced {
 public:
  explicit Traced(const ShapeTable& table) : table_(table) {
    auto built = Accelerator::build(table, textures_, embree_kernel().callbacks,
                                    {1, TESSERA_STRING(TESSERA_ISA), false});
    EXPECT_TRUE(built.ok()) << built.status();
    accelerator_ = *std::move(built);
  }
  Surface operator()(Rays& r) const {
    const RayArrays rays{r.ox, r.oy, r.oz, r.dx, r.dy, r.dz};
    trace_nearest(accelerator_->scene(), rays, kWidth, Traversal::kIncoherent, 1,
                  {r.t, r.u, r.v, r.primitive, r.shape, r.instance});
    const Hit hit{Float::load(r.t),       Float::load(r.u),   Float::load(r.v),
                  Int::load(r.primitive), Int::load(r.shape), Int(-1)};
    return surface_at(table_, hit, {Float::load(r.ox), Float::load(r.oy), Float::load(r.oz)},
                      {Float::load(r.dx), Float::load(r.dy), Float::load(r.dz)}, hit.shape >= 0, true);
  }
  /// Whether anything lies within `distance`.
  std::uint32_t blocked(const Rays& r, float distance) const {
    alignas(64) float out[kWidth];
    std::fill(out, out + kWidth, distance);
    trace_shadow(accelerator_->scene(), {r.ox, r.oy, r.oz, r.dx, r.dy, r.dz}, kWidth, Traversal::kIncoherent,
                 out);
    std::uint32_t bits = 0;
    for (int i = 0; i < kWidth; ++i) bits |= std::uint32_t{out[i] < 0} << i;
    return bits;
  }

 private:
  const ShapeTable& table_;
  TextureTable textures_;
  std::unique_ptr<Accelerator> accelerator_;
};

/// Stretched, turned and moved: columns are not of one length, but at right angles.
Affine placed(bool inverse) {
  const Point columns[3] = {{0.6 * 2, 0.8 * 2, 0}, {-0.8 * 0.5, 0.6 * 0.5, 0}, {0, 0, 1.5}}, at{1, -2, 3};
  Affine a;
  for (int i = 0; i < 3; ++i) {
    const Point c = inverse ? columns[i] * (1 / dot(columns[i], columns[i])) : columns[i];
    const double v[3] = {c.x, c.y, c.z};
    for (int row = 0; row < 3; ++row) a.m[inverse ? 4 * i + row : 4 * row + i] = static_cast<float>(v[row]);
  }
  const Point centre = inverse ? Point{-dot(columns[0], at) / dot(columns[0], columns[0]),
                                       -dot(columns[1], at) / dot(columns[1], columns[1]),
                                       -dot(columns[2], at) / dot(columns[2], columns[2])}
                               : at;
  a.m[3] = static_cast<float>(centre.x), a.m[7] = static_cast<float>(centre.y),
  a.m[11] = static_cast<float>(centre.z);
  return a;
}
Point apply(const Affine& a, Point p) {
  return {a.m[0] * p.x + a.m[1] * p.y + a.m[2] * p.z + a.m[3],
          a.m[4] * p.x + a.m[5] * p.y + a.m[6] * p.z + a.m[7],
          a.m[8] * p.x + a.m[9] * p.y + a.m[10] * p.z + a.m[11]};
}

ShapeTable cylinder_table() {
  ShapeTable table;
  QuadricRecord q;
  q.render_from_object = placed(false);
  q.object_from_render = placed(true);
  q.radius = 0.8f;
  q.z_min = -0.7f;
  q.z_max = 1.1f;
  q.phi_max = 4.5f;
  q.partial = 1;
  table.quadrics = {q};
  ShapeRecord shape;
  shape.kind = ShapeKind::kCylinder;
  table.shapes = {shape};
  table.world_shape_count = 1;
  return table;
}

/// The cylinder's own parameters.
Point cylinder_at(const QuadricRecord& q, double u, double v) {
  const double phi = u * q.phi_max;
  return apply(q.render_from_object, {q.radius * std::cos(phi), q.radius * std::sin(phi),
                                      q.z_min + v * (double{q.z_max} - q.z_min)});
}

TEST(CylinderSurface, HitsNormalsAndTangentsAgreeWithTheParameters) {
  const ShapeTable table = cylinder_table();
  const QuadricRecord& q = table.quadrics[0];
  const Traced traced(table);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int hits = 0, misses = 0;
  for (int k = 0; k < 500; ++k) {
    Rays rays;
    for (int i = 0; i < kWidth; ++i) {
      const Point o = Point{1, -2, 3} + Point{uniform(random), uniform(random), uniform(random)} * 6;
      const Point towards = Point{1, -2, 3} + Point{uniform(random), uniform(random), uniform(random)} * 1.5;
      rays.set(i, o, towards - o);
    }
    const Surface s = traced(rays);
    for (int i = 0; i < kWidth; ++i) {
      // The nearest root by the quadratic formula, in object space.
      const Point o = apply(q.object_from_render, rays.origin(i));
      const Point d = apply(q.object_from_render, rays.origin(i) + rays.direction(i)) - o;
      const double a = d.x * d.x + d.y * d.y, b = o.x * d.x + o.y * d.y,
                   c = o.x * o.x + o.y * o.y - double{q.radius} * q.radius;
      double expected = -1, margin = 1;
      if (b * b > a * c) {
        for (const double t : {(-b - std::sqrt(b * b - a * c)) / a, (-b + std::sqrt(b * b - a * c)) / a}) {
          const Point p = o + d * t;
          double phi = std::atan2(p.y, p.x);
          if (phi < 0) phi += 2 * M_PI;
          margin = std::min({margin, std::abs(p.z - q.z_min), std::abs(p.z - q.z_max),
                             std::abs(phi - q.phi_max), phi, std::abs(t)});
          if (t > 0 && p.z >= q.z_min && p.z <= q.z_max && phi <= q.phi_max && expected < 0) expected = t;
        }
        margin = std::min(margin, b * b - a * c);
      }
      if (margin < 1e-4) continue;  // an edge or the outline, within rounding
      ASSERT_EQ(rays.shape[i] >= 0, expected >= 0);
      misses += expected < 0;
      if (expected < 0) continue;
      ++hits;
      // Distances about 10, roots of floats: 1e-5 or so, more where the ray is along the wall (margin of the
      // discriminant).
      ASSERT_NEAR(rays.t[i], expected, 2e-4);
      const double u = s.uv.x.lane(i), v = s.uv.y.lane(i);
      const Point p = lane(s.p, i), exact = cylinder_at(q, u, v);
      ASSERT_LT(length(p - exact), 1e-5);
      constexpr double h = 1e-4;  // step of u and v in [0, 1]: differences are good to h^2
      const Point dpdu = (cylinder_at(q, u + h, v) - cylinder_at(q, u - h, v)) * (0.5 / h);
      const Point dpdv = (cylinder_at(q, u, v + h) - cylinder_at(q, u, v - h)) * (0.5 / h);
      ASSERT_LT(length(lane(s.dpdu, i) - dpdu), 1e-4 * length(dpdu));
      ASSERT_LT(length(lane(s.dpdv, i) - dpdv), 1e-4 * length(dpdv));
      const Point outward = cross(dpdu, dpdv) * (1 / length(cross(dpdu, dpdv)));
      ASSERT_LT(length(lane(s.ng, i) - outward), 1e-4);
      // The true surface lies within the bound along the normal; the placement stretches by 2 at most.
      const Point back = apply(q.object_from_render, p);
      const double off = std::abs(std::hypot(back.x, back.y) - q.radius) * 2;
      ASSERT_LT(off, 4 * s.error.lane(i));
      ASSERT_LT(s.error.lane(i), 2e-5);
      ASSERT_EQ(traced.blocked(rays, rays.t[i] * 1.001f) >> i & 1, 1u);
      ASSERT_EQ(traced.blocked(rays, rays.t[i] * 0.999f) >> i & 1, 0u);
    }
  }
  EXPECT_GT(hits, 1000);
  EXPECT_GT(misses, 500);
}

TEST(CylinderSurface, ParametersMayBeMapped) {
  ShapeTable plain = cylinder_table(), mapped = cylinder_table();
  mapped.quadrics[0].maps_uv = 1;
  const float map[6] = {0.2f, 1.5f, 0.3f, -2, 0.5f, 0.1f};
  std::copy(map, map + 6, mapped.quadrics[0].uv_map);
  Rays rays;
  for (int i = 0; i < kWidth; ++i)
    rays.set(i, cylinder_at(plain.quadrics[0], 0.05 * i + 0.1, 0.5) + Point{0, 0, 0.01 * i} + Point{9, 1, 0},
             {-9, -1, 0});
  Rays same = rays;
  const Surface a = Traced(plain)(rays), b = Traced(mapped)(same);
  int hits = 0;
  for (int i = 0; i < kWidth; ++i) {
    if (rays.shape[i] < 0) continue;
    ++hits;
    const double u = a.uv.x.lane(i), v = a.uv.y.lane(i);
    EXPECT_NEAR(b.uv.x.lane(i), 0.2 * u + 1.5 * v + 0.3, 1e-6);
    EXPECT_NEAR(b.uv.y.lane(i), -2 * u + 0.5 * v + 0.1, 1e-6);
    // The chain rule: dp/du = dp/du' du'/du + dp/dv' dv'/du.
    EXPECT_LT(length(lane(b.dpdu, i) * 0.2 + lane(b.dpdv, i) * -2 - lane(a.dpdu, i)), 1e-4);
    EXPECT_LT(length(lane(b.dpdu, i) * 1.5 + lane(b.dpdv, i) * 0.5 - lane(a.dpdv, i)), 1e-4);
  }
  EXPECT_GT(hits, 4);
}

/// Samples of `distance` over the unit cube, placed as it is.
ShapeTable sdf_table(std::array<std::int32_t, 3> size, const std::function<double(Point)>& distance,
                     bool smooth) {
  ShapeTable table;
  SdfGridRecord grid;
  grid.smooth_normals = smooth;
  Affine identity{};
  identity.m[0] = identity.m[5] = identity.m[10] = 1;
  grid.render_from_object = grid.object_from_render = identity;
  std::copy(size.begin(), size.end(), grid.size);
  for (std::int32_t z = 0; z < size[2]; ++z) {
    for (std::int32_t y = 0; y < size[1]; ++y) {
      for (std::int32_t x = 0; x < size[0]; ++x) {
        grid.samples.push_back(
            static_cast<float>(distance({x / (size[0] - 1.0), y / (size[1] - 1.0), z / (size[2] - 1.0)})));
      }
    }
  }
  // All voxels: those without a piece of the surface must find none.
  for (std::int32_t z = 0; z + 1 < size[2]; ++z) {
    for (std::int32_t y = 0; y + 1 < size[1]; ++y) {
      for (std::int32_t x = 0; x + 1 < size[0]; ++x) grid.voxels.push_back((z * size[1] + y) * size[0] + x);
    }
  }
  table.sdf_grids = {grid};
  ShapeRecord shape;
  shape.kind = ShapeKind::kSdfGrid;
  table.shapes = {shape};
  table.world_shape_count = 1;
  return table;
}

TEST(SdfSurface, PlanesAreExactAndHaveNoHoles) {
  // A plane is trilinear itself. Through samples and along faces of voxels in one case, slanted in the
  // others.
  for (const auto& [normal, offset] : {std::pair{Point{0, 0, 1}, 0.5},
                                       {Point{0, 0, 1}, 0.47},
                                       {Point{0.6, 0, 0.8}, 0.7},
                                       {Point{0.48, 0.64, 0.6}, 0.86}}) {
    const Point n = normal;
    const double at = offset;
    const ShapeTable table = sdf_table(
        {9, 9, 9}, [&](Point p) { return dot(p, n) - at; }, false);
    const Traced traced(table);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(0.15, 0.85);
    int holes = 0, tried = 0;
    for (int k = 0; k < 4000; ++k) {
      Rays rays;
      for (int i = 0; i < kWidth; ++i) {
        // At a point of the plane: anywhere, on a face of voxels, or on an edge.
        Point p{uniform(random), uniform(random), 0};
        if (k % 3 > 0) p.x = std::round(p.x * 8) / 8;
        if (k % 3 > 1) p.y = std::round(p.y * 8) / 8;
        p.z = (at - p.x * n.x - p.y * n.y) / n.z;
        const Point d = k % 2 ? Point{0, 0, -1} : Point{uniform(random) - 0.5, uniform(random) - 0.5, -1};
        rays.set(i, p - d * 2, d);
      }
      const Surface s = traced(rays);
      for (int i = 0; i < kWidth; ++i) {
        const double expected = (at - dot(rays.origin(i), n)) / dot(rays.direction(i), n);
        const Point p = rays.origin(i) + rays.direction(i) * expected;
        if (p.z < 0.01 || p.z > 0.99) continue;
        ++tried;
        if (rays.shape[i] < 0) {
          ++holes;
          continue;
        }
        // Coordinates about 2 and a root to 1e-7 of a voxel: 2e-6.
        ASSERT_NEAR(rays.t[i], expected, 4e-6);
        ASSERT_LT(length(lane(s.ng, i) - n), 1e-5);
        ASSERT_LE(std::abs(dot(lane(s.p, i), n) - at), s.error.lane(i));
        ASSERT_LT(s.error.lane(i), 2e-5);
      }
    }
    EXPECT_EQ(holes, 0) << tried << " rays, plane " << n.x << ' ' << n.y << ' ' << n.z << ' ' << at;
    EXPECT_GT(tried, 20000);
  }
}

/// Value of a trilinear field between eight corners (x + 2 y + 4 z), in double.
double field_at(const std::array<double, 8>& corners, Point p) {
  double sum = 0;
  for (int i = 0; i < 8; ++i) {
    const double along[3] = {i & 1 ? p.x : 1 - p.x, i & 2 ? p.y : 1 - p.y, i & 4 ? p.z : 1 - p.z};
    sum += corners[static_cast<std::size_t>(i)] * along[0] * along[1] * along[2];
  }
  return sum;
}

TEST(SdfSurface, HitsAreRootsOfTheField) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0, 1), value(-1, 1);
  int hits = 0;
  for (int k = 0; k < 4000; ++k) {
    std::array<double, 8> corners;
    for (double& corner : corners) corner = static_cast<float>(value(random));
    const ShapeTable table = sdf_table(
        {2, 2, 2}, [&](Point p) { return field_at(corners, p); }, false);
    const Traced traced(table);
    Rays rays;
    for (int i = 0; i < kWidth; ++i) {
      const Point to{uniform(random), uniform(random), uniform(random)};
      const Point from{4 * uniform(random) - 2, 4 * uniform(random) - 2, 4 * uniform(random) - 2};
      const Point way = to - from;
      rays.set(i, from, way * (1 / length(way)));
    }
    traced(rays);
    for (int i = 0; i < kWidth; ++i) {
      if (rays.shape[i] < 0) continue;
      ++hits;
      // Between corners of +-1, the field rises by at most 2 sqrt 3 along a ray. The ray's numbers, the
      // voxel's and t are below 8, so the place is off by some 8 2^-24, of which each coordinate has a part;
      // the cubic's coefficients add roundings of sums of 8 corners: 32 2^-24 in all, times the slope.
      EXPECT_NEAR(field_at(corners, rays.origin(i) + rays.direction(i) * double{rays.t[i]}), 0,
                  32 * 2 * std::sqrt(3.0) * 0x1p-24);
    }
  }
  EXPECT_GT(hits, 20000);
}

TEST(SdfSurface, SpheresToTheOrderOfInterpolation) {
  const Point centre{0.5, 0.52, 0.49};
  constexpr double kRadius = 0.3;
  constexpr int kSize = 33;
  for (const bool smooth : {false, true}) {
    const ShapeTable table = sdf_table(
        {kSize, kSize, kSize}, [&](Point p) { return length(p - centre) - kRadius; }, smooth);
    const Traced traced(table);
    std::mt19937 random(4);
    std::normal_distribution<double> normal;
    // Trilinear interpolation is off by h^2 / 8 times the sum of second derivatives, 2 / r in all; its
    // gradient by h / 2 times the largest along each axis.
    const double h = 1.0 / (kSize - 1), off = h * h / 8 * 2 / kRadius,
                 tilt = std::sqrt(3.0) * h / 2 / kRadius;
    double worst_tilt = 0;
    int holes = 0;
    for (int k = 0; k < 2000; ++k) {
      Rays rays;
      std::array<Point, kWidth> expected;
      for (int i = 0; i < kWidth; ++i) {
        const Point out{normal(random), normal(random), normal(random)}, towards = out * (1 / length(out));
        expected[static_cast<std::size_t>(i)] = towards;
        rays.set(i, centre + towards * 2, towards * -1);
      }
      const Surface s = traced(rays);
      for (int i = 0; i < kWidth; ++i) {
        if (rays.shape[i] < 0) {
          ++holes;
          continue;
        }
        const Point out = expected[static_cast<std::size_t>(i)];
        ASSERT_NEAR(rays.t[i], 2 - kRadius, off + 1e-5);
        ASSERT_LT(length(lane(s.ng, i) - out), tilt);
        ASSERT_LT(length(lane(s.ns, i) - out), tilt);
        worst_tilt = std::max(worst_tilt, length(lane(s.ns, i) - out));
        ASSERT_NEAR(length(lane(s.ns, i)), 1, 1e-5);
      }
    }
    EXPECT_EQ(holes, 0);
    // Gradients blended across voxels are right to a higher order.
    if (smooth) {
      EXPECT_LT(worst_tilt, 0.25 * tilt);
    }
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
