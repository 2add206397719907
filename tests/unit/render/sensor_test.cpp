// Rays of the cameras, and the way back from points to the film.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "render/sensor/sensor.h"
#include "support/kernel/chi2.h"
#include "support/kernel/random_lanes.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// x right along world y, y up along z, z forward along x; scaled by `s`.
SensorRecord sensor_of(SensorKind kind, float s = 1) {
  SensorRecord c;
  c.kind = kind;
  for (float& m : c.render_from_sensor.m) m = 0;
  c.render_from_sensor.m[2] = c.render_from_sensor.m[4] = c.render_from_sensor.m[9] = s;
  c.width = c.height = 32;
  c.scale_x = 2.0f / 32, c.offset_x = -1;
  c.scale_y = -2.0f / 32, c.offset_y = 1;
  return c;
}

TEST(Sensor, OrthographicRaysAreParallelAndInTheirPlaces) {
  const SensorRecord c = sensor_of(SensorKind::kOrthographic);
  const SensorRay ray = start_ray(c, {{Float(24.0f), Float(4.0f)}, {Float(0.3f), Float(0.7f)}, Float(0.0f)});
  EXPECT_FLOAT_EQ(ray.origin.x.lane(0), 0);
  EXPECT_FLOAT_EQ(ray.origin.y.lane(0), 0.5f);   // right of the middle
  EXPECT_FLOAT_EQ(ray.origin.z.lane(0), 0.75f);  // above
  EXPECT_FLOAT_EQ(ray.direction.x.lane(0), 1);
}

TEST(Sensor, LensRaysMeetInThePlaneOfFocus) {
  for (const SensorKind kind : {SensorKind::kPinhole, SensorKind::kOrthographic}) {
    SensorRecord c = sensor_of(with_lens(kind));
    c.lens_radius = 0.5f;
    c.focal_distance = 3;
    RandomLanes numbers(7);
    for (int k = 0; k < 20; ++k) {
      const SensorRay ray = start_ray(c, {{Float(24.0f), Float(4.0f)}, {numbers(), numbers()}, Float(0.0f)});
      const Vec3 p = ray.origin + ray.direction * ((3.0f - ray.origin.x) / ray.direction.x);
      const float spread = kind == SensorKind::kPinhole ? 3 : 1;
      for (int l = 0; l < kWidth; ++l) {
        EXPECT_NEAR(p.y.lane(l), 0.5f * spread, 1e-6f * 4);
        EXPECT_NEAR(p.z.lane(l), 0.75f * spread, 1e-6f * 4);
      }
    }
  }
}

TEST(Sensor, SphericalCamerasSeeEveryDirectionOnce) {
  // Even film positions, and the solid angle that one of them stands for.
  for (const SensorKind kind : {SensorKind::kOctahedral, SensorKind::kEquirectangular}) {
    SensorRecord c = sensor_of(kind);
    c.scale_x = c.scale_y = 1.0f / 32;
    c.offset_x = c.offset_y = 0;
    constexpr int kSamples = 160000;
    const test::SphereGrid grid(10, 20);
    std::vector<double> observed(grid.size()), expected(grid.size());
    RandomLanes numbers(7);
    for (int i = 0; i < kSamples; i += kWidth) {
      const SensorRay ray =
          start_ray(c, {{numbers(0, 32), numbers(0, 32)}, {Float(0.0f), Float(0.0f)}, Float(0.0f)});
      // Camera space has y up; the grid's axis is the third.
      for (int l = 0; l < kWidth; ++l)
        ++observed[grid.cell(ray.direction.x.lane(l), ray.direction.y.lane(l), ray.direction.z.lane(l))];
    }
    for (std::size_t i = 0; i < grid.size(); ++i) {
      const test::SphereCell cell = grid.bounds(i);
      // Even in the angle to the pole, or in area.
      const double rows = kind == SensorKind::kOctahedral
                              ? (cell.z1 - cell.z0) / 2
                              : (std::acos(cell.z0) - std::acos(cell.z1)) / std::numbers::pi;
      expected[i] = kSamples * rows * (cell.phi1 - cell.phi0) / (2 * std::numbers::pi);
    }
    EXPECT_GT(test::chi_square_test(observed, expected).p_value, 1e-3) << static_cast<int>(kind);
  }
}

TEST(Sensor, ClippingDistancesAreDepths) {
  SensorRecord c = sensor_of(SensorKind::kPinhole);
  c.near_clip = 2;
  c.far_clip = 5;
  RandomLanes numbers(7);
  const SensorRay ray =
      start_ray(c, {{numbers(0, 32), numbers(0, 32)}, {Float(0.0f), Float(0.0f)}, Float(0.0f)});
  const auto reaches = [&](const SensorRay& from, Float t) {
    return is_within_reach(c, from.direction, t, Float(0.0f)).bits() == Mask::all().bits();
  };
  for (int l = 0; l < kWidth; ++l) EXPECT_NEAR(ray.origin.x.lane(l), 2, 1e-5f);
  const Float to_far_plane = 3.0f / ray.direction.x;
  EXPECT_TRUE(reaches(ray, to_far_plane * 0.99999f));
  EXPECT_TRUE(none(is_within_reach(c, ray.direction, to_far_plane * 1.00001f, Float(0.0f))));
  // All around, they are distances.
  c = sensor_of(SensorKind::kOctahedral);
  c.scale_x = c.scale_y = 1.0f / 32;
  c.offset_x = c.offset_y = 0;
  c.near_clip = 2;
  c.far_clip = 5;
  const SensorRay round =
      start_ray(c, {{numbers(0, 32), numbers(0, 32)}, {Float(0.0f), Float(0.0f)}, Float(0.0f)});
  for (int l = 0; l < kWidth; ++l) EXPECT_NEAR(length(round.origin).lane(l), 2, 1e-5f);
  EXPECT_TRUE(reaches(round, Float(2.9999f)));
  EXPECT_TRUE(none(is_within_reach(c, round.direction, Float(3.0001f), Float(0.0f))));
}

TEST(Sensor, ConnectionsLeadBackToTheFilm) {
  for (const SensorKind kind : {SensorKind::kPinhole, SensorKind::kOrthographic}) {
    for (const float lens_radius : {0.0f, 0.5f}) {
      for (const float scale : {1.0f, 2.0f}) {
        SensorRecord c = sensor_of(lens_radius > 0 ? with_lens(kind) : kind, scale);
        c.lens_radius = lens_radius;
        c.focal_distance = 3;
        RandomLanes numbers(7);
        for (int k = 0; k < 100; ++k) {
          const Vec2 film{numbers(0, 32), numbers(0, 32)}, u{numbers(), numbers()};
          const SensorRay ray = start_ray(c, {film, u, Float(0.0f)});
          const Vec3 p = ray.origin + ray.direction * numbers(0.5f, 20);
          const SensorConnection back = connect_to_sensor(c, p, u, Float(0.0f), Mask::all());
          for (int l = 0; l < kWidth; ++l) {
            ASSERT_TRUE(back.valid.bits() >> l & 1);
            // Points up to 30 away, known to 4e-6, are seen as close as 0.5: pixels are 1/16 of a unit at
            // distance 1.
            ASSERT_NEAR(back.raster.x.lane(l), film.x.lane(l), 2e-3);
            ASSERT_NEAR(back.raster.y.lane(l), film.y.lane(l), 2e-3);
            ASSERT_NEAR(length(back.lens - ray.origin).lane(l), 0, 1e-4);
          }
        }
      }
    }
  }
}

TEST(Sensor, ConnectionsAreValidBetweenTheClippingDistances) {
  SensorRecord c = sensor_of(SensorKind::kPinhole, 2);
  c.near_clip = 2;
  c.far_clip = 5;
  const auto valid = [&](float depth) {
    return connect_to_sensor(c, {Float(depth), Float(0.1f), Float(0.2f)}, {Float(0.0f), Float(0.0f)},
                             Float(0.0f), Mask::all())
               .valid.bits() == 0xffffu;
  };
  EXPECT_FALSE(valid(-3));
  EXPECT_FALSE(valid(1.99f));
  EXPECT_TRUE(valid(2.01f));
  EXPECT_TRUE(valid(4.99f));
  EXPECT_FALSE(valid(5.01f));
  // Half of the way lies before the near plane, from which on nothing is in the way.
  const SensorConnection half = connect_to_sensor(c, {Float(4.0f), Float(0.1f), Float(0.2f)},
                                                  {Float(0.0f), Float(0.0f)}, Float(0.0f), Mask::all());
  EXPECT_NEAR(half.open_part.lane(0), 0.5f, 1e-6f);
}

TEST(Sensor, ImportanceTurnsFilmIntoArea) {
  // A patch of a plane at right angles to the ray, through one point of the lens: its share of a pixel by
  // finite differences of the film position. In render space, whatever the scale of camera space.
  for (const SensorKind kind : {SensorKind::kPinhole, SensorKind::kOrthographic}) {
    for (const float scale : {1.0f, 2.0f}) {
      SensorRecord c = sensor_of(with_lens(kind), scale);
      c.lens_radius = 0.2f;
      c.focal_distance = 3;
      const Vec2 u{Float(0.8f), Float(0.3f)};
      const Vec3 p{Float(6.0f), Float(1.5f), Float(-2.0f)};
      const auto film = [&](float y, float z) {
        // Through the same lens point the patch lies along y and z; its cosine to the ray is accounted for
        // below.
        return connect_to_sensor(c, p + Vec3{Float(0.0f), Float(y), Float(z)}, u, Float(0.0f), Mask::all())
            .raster;
      };
      constexpr float h = 0.125f;
      const Vec2 y1 = film(h, 0), y0 = film(-h, 0), z1 = film(0, h), z0 = film(0, -h);
      const double pixels = std::abs((y1.x - y0.x).lane(0) * (z1.y - z0.y).lane(0) -
                                     (y1.y - y0.y).lane(0) * (z1.x - z0.x).lane(0)) /
                            (4.0 * h * h);
      const SensorConnection seen = connect_to_sensor(c, p, u, Float(0.0f), Mask::all());
      const Vec3 w = normalize(seen.lens - p);
      // The value of a pixel: radiance x importance x cosine x area, a whole pixel's worth of film giving the
      // radiance itself.
      EXPECT_NEAR(seen.importance.lane(0) * std::abs(w.x.lane(0)), pixels, 1e-4 * pixels)
          << static_cast<int>(kind) << ' ' << scale;
    }
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
