// Points on curves, at what Embree says of rays that meet them.
#include <gtest/gtest.h>

#include <cmath>

#include "render/accel/embree/curve_geometry.h"
#include "render/shape/surface.h"

namespace tessera::render::TESSERA_ISA {
namespace {

float lane(Float x) {
  alignas(64) float lanes[kWidth];
  x.store(lanes);
  return lanes[0];
}

/// One segment along x from 0 to 3, of radius 0.5.
ShapeTable straight(CurveKind kind) {
  ShapeTable table;
  CurvesRecord& curves = table.curves.emplace_back();
  curves.kind = kind;
  for (int i = 0; i < 4; ++i) curves.points.push_back({{static_cast<float>(i), 0, 0}, 0.5f});
  curves.starts = {0};
  if (kind == CurveKind::kRibbon) {
    for (int i = 0; i < 4; ++i) curves.normals.insert(curves.normals.end(), {0, 0, 1});
    curves.normals.push_back(0);
  }
  ShapeRecord& shape = table.shapes.emplace_back();
  shape.kind = ShapeKind::kCurves;
  return table;
}

/// Surface of the first shape where a ray meets it; `hit` says whether it does.
struct Seen {
  bool hit = false;
  Surface surface;
};

Seen look(const ShapeTable& table, const float (&o)[3], const float (&d)[3]) {
  RTCDevice device = rtcNewDevice("threads=1");
  RTCScene scene = rtcNewScene(device);
  RTCGeometry geometry = new_curve_geometry(device, table.curves[0]);
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, 0);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  alignas(64) int valid[4] = {-1, 0, 0, 0};
  alignas(64) RTCRayHit4 ray = {};
  ray.ray.org_x[0] = o[0], ray.ray.org_y[0] = o[1], ray.ray.org_z[0] = o[2];
  ray.ray.dir_x[0] = d[0], ray.ray.dir_y[0] = d[1], ray.ray.dir_z[0] = d[2];
  ray.ray.tfar[0] = 100, ray.ray.mask[0] = ~0u;
  ray.hit.geomID[0] = RTC_INVALID_GEOMETRY_ID;
  TraceContext(Traversal::kIncoherent).intersect(valid, scene, ray);
  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
  Seen seen;
  seen.hit = ray.hit.geomID[0] == 0;
  if (!seen.hit) return seen;
  const Hit hit{Float(ray.ray.tfar[0]), Float(ray.hit.u[0]), Float(ray.hit.v[0]), Int(0), Int(0), Int(-1)};
  seen.surface = surface_at(table, hit, {Float(o[0]), Float(o[1]), Float(o[2])},
                            {Float(d[0]), Float(d[1]), Float(d[2])}, Mask::all(), true);
  return seen;
}

TEST(CurveSurface, ParametersRunAlongAndAcross) {
  // From +z downwards; across = cross(ng, dp/du) = cross(z, x) = y.
  const Seen seen = look(straight(CurveKind::kFlat), {1.5f, 0.25f, 4}, {0, 0, -1});
  ASSERT_TRUE(seen.hit);
  EXPECT_NEAR(lane(seen.surface.p.x), 1.5f, 1e-4f);  // Embree's u
  EXPECT_NEAR(lane(seen.surface.p.y), 0.25f, 1e-6f);
  EXPECT_NEAR(lane(seen.surface.uv.x), 0.5f, 1e-4f);
  EXPECT_NEAR(lane(seen.surface.uv.y), 0.75f, 1e-6f);
  EXPECT_NEAR(lane(seen.surface.ng.z), 1, 1e-6f);
  EXPECT_NEAR(lane(seen.surface.dpdu.x), 3, 1e-5f);
  EXPECT_NEAR(lane(seen.surface.dpdv.y), 1, 1e-6f);
  EXPECT_GT(lane(seen.surface.error), 2 * 0.5f);  // rays leave beyond the curve's own thickness
  EXPECT_FALSE(look(straight(CurveKind::kFlat), {1.5f, 0.51f, 4}, {0, 0, -1}).hit);
}

TEST(CurveSurface, FlatCurvesFaceEveryRay) {
  const float s = std::sqrt(0.5f);
  // At 45 degrees about the axis: as wide as from above.
  const Seen seen = look(straight(CurveKind::kFlat), {1, 4 + 0.3f * s, 4 - 0.3f * s}, {0, -s, -s});
  ASSERT_TRUE(seen.hit);
  EXPECT_NEAR(std::abs(2 * lane(seen.surface.uv.y) - 1), 0.6f, 1e-4f);
  EXPECT_NEAR(lane(seen.surface.ng.y), s, 1e-5f);
  // A ribbon stays where its normal says.
  const Seen ribbon = look(straight(CurveKind::kRibbon), {1, 4 + 0.3f, 4}, {0, -s, -s});
  ASSERT_TRUE(ribbon.hit);
  EXPECT_NEAR(lane(ribbon.surface.ng.z), 1, 1e-4f);
  EXPECT_NEAR(lane(ribbon.surface.uv.y), 0.5f + 0.3f, 1e-3f);  // Embree's t
}

TEST(CurveSurface, CylindersBendTheirNormals) {
  const Seen seen = look(straight(CurveKind::kCylinder), {2, 0.25f, 4}, {0, 0, -1});
  ASSERT_TRUE(seen.hit);
  // Half way to the edge: 45 degrees, leaning outwards; the frame stays right-handed.
  EXPECT_NEAR(lane(seen.surface.ns.y), std::sqrt(0.5f), 1e-5f);
  EXPECT_NEAR(lane(seen.surface.ns.z), std::sqrt(0.5f), 1e-5f);
  EXPECT_NEAR(lane(seen.surface.ng.z), 1, 1e-6f);
  const Vec3 n = normalize(cross(seen.surface.dpdu, seen.surface.dpdv));
  EXPECT_NEAR(lane(dot(n, seen.surface.ns)), 1, 1e-5f);
}

TEST(CurveSurface, SplinesAndParametersAgreeWithEmbree) {
  ShapeTable table = straight(CurveKind::kFlat);
  CurvesRecord& curves = table.curves[0];
  curves.bspline = 1;  // runs from x = 1 to x = 2
  curves.params = {0.5f, 1.5f};
  const Seen seen = look(table, {1.25f, 0, 4}, {0, 0, -1});
  ASSERT_TRUE(seen.hit);
  EXPECT_NEAR(lane(seen.surface.p.x), 1.25f, 1e-4f);
  EXPECT_NEAR(lane(seen.surface.uv.x), 0.75f, 1e-4f);
  EXPECT_FALSE(look(table, {0.5f, 0, 4}, {0, 0, -1}).hit);
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
