// The part of a plane that a pixel covers, against the camera's own rays.
#include "render/sensor/footprint.h"

#include <gtest/gtest.h>

#include <cmath>

#include "render/sensor/footprint_record.h"
#include "render/sensor/sensor.h"

namespace tessera::render::TESSERA_ISA::footprint_cases {
namespace {

/// Looks along world x, y up along z; all axes of length 2.
SensorRecord sensor_of(SensorKind kind) {
  SensorRecord c;
  c.kind = kind;
  for (float& m : c.render_from_sensor.m) m = 0;
  c.render_from_sensor.m[2] = c.render_from_sensor.m[4] = c.render_from_sensor.m[9] = 2;
  c.render_from_sensor.m[3] = 0.5f, c.render_from_sensor.m[7] = -0.25f, c.render_from_sensor.m[11] = 0.125f;
  c.width = c.height = 512;
  const bool all_around = kind == SensorKind::kEquirectangular || kind == SensorKind::kOctahedral;
  c.scale_x = all_around ? 1.0f / 512 : 1.5f / 512, c.scale_y = all_around ? 1.0f / 512 : -1.5f / 512;
  if (!all_around) c.offset_x = -0.75f, c.offset_y = 0.75f;
  return c;
}

struct Plane {
  Vec3 n;   // unit
  Float d;  // dot(n, p)

  Vec3 meet(const SensorRay& ray) const {
    return fma(ray.direction, (d - dot(n, ray.origin)) / dot(n, ray.direction), ray.origin);
  }
};

class FootprintTest : public testing::TestWithParam<SensorKind> {};

TEST_P(FootprintTest, HasTheAreaThatThePixelCovers) {
  const SensorRecord c = sensor_of(GetParam());
  const Vec2 middle{Float(0.5f), Float(0.5f)};
  constexpr float kPart = 0.125f;
  const FootprintRecord record = footprint_of(c, kPart);
  for (const auto& [x, y] : {std::pair{262.0f, 271.0f}, {250.0f, 300.0f}, {300.0f, 190.0f}}) {
    const SensorRay ray = start_ray(c, {{Float(x), Float(y)}, middle, Float(0.0f)});
    const Vec3 n = normalize(Vec3{Float(0.1f), Float(0.3f), Float(-0.4f)} - ray.direction);
    const Plane plane{n, dot(n, fma(ray.direction, Float(5.0f), ray.origin))};
    const auto at = [&](float dx, float dy) {
      return plane.meet(start_ray(c, {{Float(x + dx), Float(y + dy)}, middle, Float(0.0f)}));
    };
    // Central differences over two pixels: errors of the order of (1/512)^2, and of 1e-7 * 512 by rounding.
    const Vec3 dx = (at(1, 0) - at(-1, 0)) * Float(0.5f * kPart),
               dy = (at(0, 1) - at(0, -1)) * Float(0.5f * kPart);
    TexturePoint point = TexturePoint::at(middle);
    point.p = at(0, 0);
    const Frame tangents = Frame::from_normal(plane.n);
    const Vec3 dpdu = tangents.x * Float(3.0f) + tangents.y, dpdv = tangents.y * Float(0.5f);
    set_footprint(record, plane.n, dpdu, dpdv, point);
    const float expected = length(cross(dx, dy)).lane(0),
                area = length(cross(point.dpdx, point.dpdy)).lane(0);
    if (GetParam() == SensorKind::kEquirectangular) {
      EXPECT_NEAR(area, expected, 0.1f * expected);  // pixels as wide as at the equator
    } else {
      EXPECT_NEAR(area, expected, 2e-3f * expected);
    }
    // Steps in uv lead where the steps in space do, on the plane.
    for (const auto& [step, uv] : {std::pair{point.dpdx, point.duvdx}, {point.dpdy, point.duvdy}}) {
      const Vec3 along = dpdu * uv.x + dpdv * uv.y;
      EXPECT_LT(length(along - step).lane(0), 1e-4f * length(step).lane(0));
      EXPECT_LT(std::abs(dot(step, plane.n).lane(0)), 1e-4f * length(step).lane(0));
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Sensors, FootprintTest,
                         testing::Values(SensorKind::kPinhole, SensorKind::kOrthographic,
                                         SensorKind::kEquirectangular, SensorKind::kOctahedral));

TEST(Footprint, OnTheAxisItIsThatOfTheRays) {
  const SensorRecord c = sensor_of(SensorKind::kPinhole);
  const FootprintRecord record = footprint_of(c, 1);
  TexturePoint point = TexturePoint::at({Float(0.0f), Float(0.0f)});
  point.p = {Float(10.5f), Float(-0.25f), Float(0.125f)};
  const Vec3 y{Float(0.0f), Float(1.0f), Float(0.0f)}, z{Float(0.0f), Float(0.0f), Float(1.0f)};
  set_footprint(record, -Vec3{Float(1.0f), Float(0.0f), Float(0.0f)}, y, z, point);
  // 1.5 / 512 of the depth: to the right along y, and along z.
  EXPECT_NEAR(point.duvdx.x.lane(3), 10 * 1.5 / 512, 1e-6);
  EXPECT_NEAR(point.duvdx.y.lane(3), 0, 1e-6);
  EXPECT_NEAR(std::abs(point.duvdy.y.lane(3)), 10 * 1.5 / 512, 1e-6);
}

TEST(Footprint, StaysFinite) {
  const FootprintRecord record = footprint_of(sensor_of(SensorKind::kPinhole), 1);
  const Vec3 zero{Float(0.0f), Float(0.0f), Float(0.0f)}, x{Float(1.0f), Float(0.0f), Float(0.0f)},
      y{Float(0.0f), Float(1.0f), Float(0.0f)};
  const Vec3 eye{Float(0.5f), Float(-0.25f), Float(0.125f)};
  for (const Vec3& p : {eye, eye + x * Float(1e30f), eye - x, eye + y * Float(1e-30f)}) {
    for (const auto& [dpdu, dpdv] : {std::pair{x, y}, {x, x}, {zero, zero}, {x * Float(1e-25f), y}}) {
      TexturePoint point = TexturePoint::at({Float(0.0f), Float(0.0f)});
      point.p = p;
      set_footprint(record, y, dpdu, dpdv, point);  // seen from the edge
      for (const Float& d : {point.duvdx.x, point.duvdx.y, point.duvdy.x, point.duvdy.y})
        EXPECT_LE(std::abs(d.lane(2)), 1e8f);
    }
  }
  EXPECT_FALSE(footprint_of(sensor_of(SensorKind::kPinhole), 0).on);
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA::footprint_cases
