// Every sample against its own light: density, radiance, and the length of the shadow ray.
#include <gtest/gtest.h>

#include "statistical/light/lamps.h"

namespace tessera::render::TESSERA_ISA {
namespace {

void check_samples(const Lamp& lamp, Point reference) {
  SCOPED_TRACE(lamp.name);
  Random random(5);
  int valid_samples = 0;
  for (int i = 0; i < 4096; i += kWidth) {
    const Int light(i / kWidth % static_cast<int>(lamp.table.lights.size()));
    const LightSample s = sample_light(lamp.table, light, wide(reference), random.next_2d(), Mask::all());
    for (int l = 0; l < kWidth; ++l) {
      if (!(s.valid.bits() >> l & 1)) continue;
      ++valid_samples;
      const Point w = lane(s.wi, l);
      ASSERT_NEAR(length(w), 1, 1e-6);
      ASSERT_FALSE(s.delta.bits() >> l & 1);
      const double distance = s.distance.lane(l);
      // The hit that the sample meant is the one nearest to its end. Samples within rounding of the outline
      // may miss.
      const LampHit* hit = nullptr;
      const std::vector<LampHit> hits = lamp.hits(reference, w);
      for (const LampHit& h : hits) {
        if (!hit || std::abs(h.t - distance) < std::abs(hit->t - distance)) hit = &h;
      }
      if (!hit) continue;
      const double cosine = std::abs(dot(hit->n, w));
      // The ray ends before the light, and not long before: the bound is below 2^-19 of the coordinates' size
      // over the cosine.
      const double size = length(reference) + length(hit->p) + 4;
      ASSERT_LT(distance, hit->t);
      ASSERT_GT(distance, hit->t - 0x1p-19 * size * 1.8 / std::max(cosine, 1e-6));

      const Float pdf =
          light_pdf(lamp.table, light, wide(reference), s.wi, wide(hit->p), wide(hit->n), Mask::all());
      // The float density and the double hit differ by the relative error of the cosine.
      if (cosine > 1e-2) {
        ASSERT_NEAR(pdf.lane(l), s.pdf.lane(l), 1e-3 * s.pdf.lane(l));
      }
      Surface surface{};
      surface.ng = wide(hit->n);
      const Spectrum le = emitted_radiance(lamp.table, light, surface, -s.wi, Mask::all());
      for (int c = 0; c < 3; ++c) ASSERT_EQ(le.c[c].lane(l), s.radiance.c[c].lane(l));
    }
  }
  EXPECT_GT(valid_samples, 1000);
}

TEST(LightSample, AgreesWithItsLight) {
  QuadricRecord ring;
  ring.radius = 1.3f;
  ring.inner_radius = 0.6f;
  const Lamp quad =
      mesh_lamp("quad", {{0, 0, 2}, {0, 1, 2}, {1, 1, 2}, {1, 0, 2}}, {0, 1, 2, 0, 2, 3}, false);
  const Lamp disk = quadric_lamp("ring", ShapeKind::kDisk, ring, placed({1, 2, 3}, {1, 0.6, 1}), false, true);
  const Lamp sphere =
      quadric_lamp("sphere", ShapeKind::kSphere, sphere_record(0.8f), placed({1, 2, 3}), false, false);
  const Lamp inward =
      quadric_lamp("inward", ShapeKind::kSphere, sphere_record(5), placed({1, 2, 3}), true, false);
  QuadricRecord tube;
  tube.radius = 0.6f;
  tube.z_min = -0.4f;
  tube.z_max = 0.9f;
  const Lamp cylinder =
      quadric_lamp("cylinder", ShapeKind::kCylinder, tube, placed({1, 2, 3}, {1, 0.6, 1}), false, true);
  for (const Point reference : {Point{0, 0, 0}, Point{0.3, 0.2, 1.99}, Point{0.4, 0.9, 1}}) {
    for (const Lamp* lamp : {&quad, &disk, &sphere, &inward}) check_samples(*lamp, reference);
  }
  // Seen from inside: at the outline the two walls are within rounding of each other.
  check_samples(cylinder, {1.1, 2.1, 3.2});
  check_samples(sphere, {-300, 200, 100});
  check_samples(quad, {-30, 20, -10});
}

TEST(LightSample, SoftLightsAreSampledOnTheirSphere) {
  const float radius = 0.8f;
  for (const LightKind kind : {LightKind::kSoftPoint, LightKind::kSoftSpot}) {
    Lamp lamp = soft_lamp("soft", kind, {1, 2, 3}, radius);
    lamp.table.lights[0].cos_inner = lamp.table.lights[0].cos_outer = -1;  // a cone that is all directions
    for (const Point reference :
         {Point{0, 0, 0}, Point{1, 2, 2.15}, Point{1.3, 1.8, 2.7}, Point{1, 2, 3}, Point{-300, 200, 100}}) {
      const bool outside = length(reference - lamp.centre) > radius;
      Random random(6);
      int near = 0, all = 0;
      for (int i = 0; i < 4096; i += kWidth) {
        const LightSample s =
            sample_light(lamp.table, Int(0), wide(reference), random.next_2d(), Mask::all());
        for (int l = 0; l < kWidth; ++l) {
          ASSERT_TRUE(s.valid.bits() >> l & 1);
          ASSERT_TRUE(s.delta.bits() >> l & 1);
          ++all;
          const double distance = s.distance.lane(l);
          const std::vector<LampHit> hits = lamp.hits(reference, lane(s.wi, l));
          if (hits.empty()) continue;  // it is within rounding of the outline
          const LampHit& hit = std::abs(hits.front().t - distance) < std::abs(hits.back().t - distance)
                                   ? hits.front()
                                   : hits.back();
          near += hits.size() == 2 && &hit == &hits.front();
          const double cosine = std::abs(dot(hit.n, lane(s.wi, l)));
          // Directions are off by some 2^-22, which moves a point along the ray by that times the distance
          // over the cosine.
          const double size = length(reference) + length(hit.p) + radius;
          ASSERT_NEAR(distance, hit.t, 0x1p-19 * size * 1.8 / std::max(cosine, 1e-3));
          // The cosine's square is off by the distance's share of rounding, in squares of the radius.
          ASSERT_NEAR(s.cosine.lane(l) * s.cosine.lane(l), cosine * cosine, 1e-5 * size * size);
        }
      }
      // Half of 4096 on the near wall: five standard deviations of 32.
      EXPECT_NEAR(near, outside ? all / 2 : 0, outside ? 160 : 0);
    }
  }
}

TEST(LightSample, SoftLightsOfAnySizeAreFinite) {
  Random random(8);
  for (const float radius : {1e-30f, 1e-18f, 1e-9f, 1e9f, 1e18f, 1e20f, 1e30f}) {
    for (const double distance : {1e-9, 1.0, 1e9}) {
      const Lamp lamp = soft_lamp("soft", LightKind::kSoftPoint, {0, 0, 0}, radius);
      const LightSample s =
          sample_light(lamp.table, Int(0), wide({distance, 0, 0}), random.next_2d(), Mask::all());
      const Float pdf =
          light_pdf(lamp.table, Int(0), wide({distance, 0, 0}), s.wi, wide({}), wide({}), Mask::all());
      // Floats hold no squares of such radii, and the light is as dark as 0.
      EXPECT_EQ(any(s.valid), radius < 1e19f);
      for (int l = 0; l < kWidth; ++l) {
        EXPECT_TRUE(std::isfinite(s.wi.x.lane(l)));
        EXPECT_EQ(pdf.lane(l), s.pdf.lane(l));
        EXPECT_TRUE(s.pdf.lane(l) > 0 && std::isfinite(s.pdf.lane(l))) << radius << " " << distance;
        if (!(s.valid.bits() >> l & 1)) continue;
        EXPECT_TRUE(std::isfinite(s.radiance.c[0].lane(l)));
        EXPECT_TRUE(s.distance.lane(l) >= 0 && std::isfinite(s.distance.lane(l)));
        EXPECT_TRUE(s.cosine.lane(l) >= 0 && s.cosine.lane(l) <= 1.001f);
      }
    }
  }
}

TEST(LightSample, EnvironmentRadianceAgreesWithSamples) {
  const Affine turned = placed({0, 0, 0}, {1, 1, -1}).affine();
  const Lamp octahedral = environment_lamp(
      "octahedral",
      *build_environment(noise_image(8, 8, 3), EnvironmentMapping::kEqualAreaOctahedral, 3, turned));
  const Lamp latlong = environment_lamp(
      "latlong",
      *build_environment(noise_image(16, 8, 4), EnvironmentMapping::kLatitudeLongitude, 3, turned));
  for (const Lamp* lamp : {&octahedral, &latlong}) {
    SCOPED_TRACE(lamp->name);
    Random random(9);
    int differ = 0;
    for (int i = 0; i < 16000; i += kWidth) {
      const LightSample s = sample_light(lamp->table, Int(0), wide({}), random.next_2d(), Mask::all());
      const Spectrum le = environment_radiance(lamp->table, 0, wide({}), s.wi, Mask::all());
      const Float pdf = light_pdf(lamp->table, Int(0), wide({}), s.wi, wide({}), wide({}), Mask::all());
      for (int l = 0; l < kWidth; ++l) {
        ASSERT_TRUE(s.valid.bits() >> l & 1);
        const double a = s.radiance.c[1].lane(l), b = le.c[1].lane(l);
        differ += std::abs(a - b) > 1e-3 * std::max(a, b) ||
                  std::abs(pdf.lane(l) - s.pdf.lane(l)) > 1e-3 * s.pdf.lane(l);
      }
    }
    // Only directions within rounding of a texel's border (1e-6 of its size or so) may fall on the other
    // side; where the bilinear map is steep, its slope times that.
    EXPECT_LE(differ, 16);
  }
}

TEST(LightSample, LanesOfDifferentKinds) {
  Lamp lamp = quadric_lamp("all", ShapeKind::kSphere, sphere_record(0.8f), placed({1, 2, 3}), false, false);
  lamp.table.environments.push_back(*build_environment({}, EnvironmentMapping::kUniform, 1, {}));
  LightRecord point, infinite;
  point.position[0] = -2;
  point.radiance[0] = 8;
  infinite.kind = LightKind::kInfinite;
  infinite.environment = 0;
  infinite.radiance[1] = 5;
  lamp.table.lights.push_back(point);
  lamp.table.lights.push_back(infinite);
  alignas(64) std::int32_t kinds[kWidth];
  for (int l = 0; l < kWidth; ++l) kinds[l] = l % 3;
  const Mask active = ~Mask::first(3);
  Random random(2);
  const Vec2 u = random.next_2d();
  const LightSample mixed = sample_light(lamp.table, Int::load(kinds), wide({}), u, active);
  EXPECT_EQ(mixed.valid.bits(), 0xfff8u);
  for (int kind = 0; kind < 3; ++kind) {
    const LightSample one = sample_light(lamp.table, Int(kind), wide({}), u, Mask::all());
    for (int l = 3; l < kWidth; ++l) {
      if (kinds[l] != kind) continue;
      EXPECT_EQ(mixed.wi.x.lane(l), one.wi.x.lane(l));
      EXPECT_EQ(mixed.pdf.lane(l), one.pdf.lane(l));
      EXPECT_EQ(mixed.distance.lane(l), one.distance.lane(l));
      EXPECT_EQ(mixed.delta.bits() >> l & 1, kind == 1 ? 1u : 0u);
    }
  }
}

TEST(LightSample, DegenerateLightsGiveNothing) {
  // A triangle without area, a reference point on the light, and one in its plane.
  const Lamp sliver = mesh_lamp("sliver", {{0, 0, 1}, {1, 0, 1}, {2, 0, 1}}, {0, 1, 2}, true);
  const Lamp flat = mesh_lamp("flat", {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}}, {0, 1, 2}, true);
  LightRecord record;
  record.radiance[0] = 1;
  Lamp point;
  point.table.lights = {record};
  Random random(3);
  const auto valid = [&](const Lamp& lamp, Point at) {
    return sample_light(lamp.table, Int(0), wide(at), random.next_2d(), Mask::all()).valid.bits();
  };
  EXPECT_EQ(valid(sliver, {0, 0, 0}), 0u);
  EXPECT_EQ(valid(flat, {5, 5, 1}), 0u);
  EXPECT_EQ(valid(point, {0, 0, 0}), 0u);
  EXPECT_NE(valid(point, {0, 0, 1}), 0u);
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
