// Light as it leaves its sources: rays against their densities and against the power of the light.
#include <gtest/gtest.h>

#include "render/light/emission.h"
#include "render/light/light_access.h"
#include "statistical/light/lamps.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// A light that has a place but no surface, shining along z; soft ones with a radius.
Lamp positional_lamp(std::string name, LightKind kind) {
  Lamp lamp;
  lamp.name = std::move(name);
  LightRecord& record = lamp.table.lights.emplace_back();
  record.kind = kind;
  std::copy(kLampRadiance.begin(), kLampRadiance.end(), record.radiance);
  record.position[0] = 1, record.position[1] = -2, record.position[2] = 3;
  record.radius = 0.8f;
  record.cos_inner = 0.9f, record.cos_outer = 0.6f;
  record.tan_x = 0.5f, record.tan_y = 0.3f;
  for (const std::size_t i : {0, 4, 8}) record.vertices[i] = 1;
  return lamp;
}

Lamp distant_lamp() {
  Lamp lamp = positional_lamp("distant", LightKind::kDistant);
  lamp.table.scene_radius = 2.5f;
  return lamp;
}

std::vector<Lamp> lamps() {
  QuadricRecord ring, tube, cap = sphere_record(1);
  ring.radius = 2, ring.inner_radius = 0.5f, ring.height = 0.3f, ring.phi_max = 4, ring.partial = 1;
  tube.radius = 0.6f, tube.z_min = -0.4f, tube.z_max = 0.9f;
  cap.z_min = 0.2f, cap.partial = 1;
  const Map squeezed = placed({1, 2, 3}, {1, 0.6, 1.4});
  std::vector<Lamp> result;
  result.push_back(mesh_lamp("triangle", {{0, 0, 0}, {2, 0, 1}, {0, 3, 1}}, {0, 1, 2}, true));
  result.push_back(
      mesh_lamp("rectangle", {{0, 0, 1}, {2, 0, 1}, {2, 3, 1}, {0, 3, 1}}, {0, 1, 2, 0, 2, 3}, false));
  result.push_back(
      quadric_lamp("sphere", ShapeKind::kSphere, sphere_record(0.8f), placed({1, 2, 3}), false, false));
  result.push_back(quadric_lamp("squeezed cap", ShapeKind::kSphere, cap, squeezed, true, false));
  result.push_back(quadric_lamp("ring", ShapeKind::kDisk, ring, squeezed, false, true));
  result.push_back(quadric_lamp("cylinder", ShapeKind::kCylinder, tube, squeezed, false, true));
  result.push_back(positional_lamp("point", LightKind::kPoint));
  result.push_back(positional_lamp("spot", LightKind::kSpot));
  result.push_back(positional_lamp("projection", LightKind::kProjection));
  result.push_back(positional_lamp("goniometric", LightKind::kGoniometric));
  result.push_back(positional_lamp("soft point", LightKind::kSoftPoint));
  result.push_back(positional_lamp("soft spot", LightKind::kSoftSpot));
  result.push_back(distant_lamp());
  result.push_back(environment_lamp("sky", *build_environment({}, EnvironmentMapping::kUniform, 1, {})));
  result.push_back(environment_lamp(
      "octahedral",
      *build_environment(noise_image(8, 8, 3), EnvironmentMapping::kEqualAreaOctahedral, 3, {})));
  return result;
}

/// Lights that move, at one moment; those on shapes are stretched.
std::vector<Lamp> moved_lamps() {
  const Map start = placed({0.5, -0.2, 1}), turned = placed({-0.4, 0.3, 2}),
            end{{-turned.m[1], turned.m[0], turned.m[2], turned.m[3], -turned.m[5], turned.m[4], turned.m[6],
                 turned.m[7], -turned.m[9], turned.m[8], turned.m[10], turned.m[11]}},
            stretched = placed({-0.4, 0.3, 2}, {1.7, 0.8, 1.2});
  std::vector<Lamp> result;
  for (Lamp& lamp : lamps()) {
    const LightRecord& light = lamp.table.lights[0];
    if (light.kind == LightKind::kSoftSpot) continue;  // its intensity is not the same all around
    const bool on_shape = light.shape >= 0;
    // Lights at infinity, and soft ones, only turn: all of that at an end.
    result.push_back(on_shape ? moved(std::move(lamp), start, stretched, 0.6)
                              : moved(std::move(lamp), start, end, 1));
  }
  return result;
}

/// Rays of a light. Values are means of R, G and B.
struct Rays {
  double flux = 0, flux_squared = 0;
  int all = 0, valid = 0;
  int as_dense_as_said = 0;  // flux is radiance over the densities

  double mean() const { return flux / all; }
  double standard_error() const {
    return std::sqrt(std::max(0.0, flux_squared / all - mean() * mean()) / all);
  }
};

/// Radiance of light 0 along a ray of its own: of a surface times the cosine there, of a point from
/// distance 1.
Float seen_along(const Lamp& lamp, const Emission& ray, Vec3 normal, Vec2 u) {
  const LightRecord& record = lamp.table.lights[0];
  Receiver origin(wide({}));
  origin.time = lamp.time;
  if (lamp.environment)
    return environment_radiance(lamp.table, 0, origin, -ray.direction, Mask::all()).mean();
  if (record.shape >= 0)
    return LightLanes{lamp.table, Int(0), Mask::all()}.radiance().mean() * dot(normal, ray.direction);
  if (!light_model(record.kind).traits.extended) {
    Receiver from(ray.origin + ray.direction);
    from.time = lamp.time;
    return light_model(record.kind).sample(lamp.table, Int(0), from, u, Mask::all()).radiance.mean();
  }
  // A wall of the sphere sends half of the radiance that a disk with the point's intensity has.
  if (lamp.table.moving != nullptr) {
    return LightLanes{lamp.table, Int(0), Mask::all()}.radiance().mean() * dot(normal, ray.direction) /
           (2 * kPi * sqr(Float(record.radius)));
  }
  const LightKind kind = record.kind == LightKind::kSoftPoint ? LightKind::kPoint : LightKind::kSpot;
  const Vec3 centre{Float(record.position[0]), Float(record.position[1]), Float(record.position[2])};
  const Float intensity =
      light_model(kind).sample(lamp.table, Int(0), centre + ray.direction, u, Mask::all()).radiance.mean();
  return intensity * dot(normal, ray.direction) / (2 * kPi * sqr(Float(record.radius)));
}

Rays emit_rays(const Lamp& lamp, unsigned seed) {
  Random random(seed);
  Rays rays;
  constexpr int kRays = 1 << 16;
  for (int i = 0; i < kRays; i += kWidth) {
    const Vec2 place = random.next_2d(), direction = random.next_2d();
    const Emission ray = sample_emission(lamp.table, Int(0), Float(lamp.time), place, direction, Mask::all());
    const Float seen = seen_along(lamp, ray, ray.normal, direction);
    const EmissionDensity density =
        emission_density(lamp.table, Int(0), Float(lamp.time), ray.origin, dot(ray.normal, ray.direction),
                         ray.direction, Mask::all());
    for (int l = 0; l < kWidth; ++l) {
      ++rays.all;
      if (!(ray.valid.bits() >> l & 1)) continue;
      ++rays.valid;
      const double flux = ray.flux.mean().lane(l);
      rays.flux += flux, rays.flux_squared += flux * flux;
      const double expected = seen.lane(l) / (double{density.place.lane(l)} * density.direction.lane(l));
      rays.as_dense_as_said += std::abs(flux - expected) <= 1e-3 * flux;
    }
  }
  return rays;
}

TEST(LightEmission, FluxIsRadianceOverTheDensities) {
  unsigned seed = 0;
  std::vector<Lamp> all = lamps();
  for (Lamp& lamp : moved_lamps()) all.push_back(std::move(lamp));
  for (const Lamp& lamp : all) {
    SCOPED_TRACE(lamp.name);
    const Rays rays = emit_rays(lamp, ++seed);
    EXPECT_GT(rays.valid, rays.all / 2);
    // Some thirty roundings of 6e-8 are well within 1e-3, but for what they are divided by: cosines below
    // 0.01 (1e-4 of the rays, by their density), edges of cones and pictures, and borders of texels (1e-6 of
    // their sizes). A density that is wrong is wrong for all rays.
    EXPECT_GT(rays.as_dense_as_said, 0.999 * rays.valid);
  }
}

TEST(LightEmission, AddsUpToThePower) {
  unsigned seed = 100;
  for (const Lamp& lamp : lamps()) {
    const LightRecord& record = lamp.table.lights[0];
    if (record.kind == LightKind::kProjection) continue;  // its power is an estimate
    SCOPED_TRACE(lamp.name);
    const Rays rays = emit_rays(lamp, ++seed);
    const double power = lamp.table.sources(record.kind).power(lamp.table, record);
    // 4.5 standard errors leave 14 lights a chance of 1e-4 in all; areas of squeezed quadrics, by quadrature,
    // are right to 1e-4.
    EXPECT_NEAR(rays.mean(), power, 4.5 * rays.standard_error() + 1e-4 * power);
  }
}

TEST(LightEmission, SoftLightsSendFromBothSidesOfTheirSphere) {
  for (const LightKind kind : {LightKind::kSoftPoint, LightKind::kSoftSpot}) {
    const Lamp lamp = positional_lamp("soft", kind);
    const LightRecord& record = lamp.table.lights[0];
    const Point centre{record.position[0], record.position[1], record.position[2]};
    Random random(4);
    int outwards = 0, all = 0;
    Point mean;
    for (int i = 0; i < 1 << 16; i += kWidth) {
      const Emission ray =
          sample_emission(lamp.table, Int(0), Float(0.0f), random.next_2d(), random.next_2d(), Mask::all());
      for (int l = 0; l < kWidth; ++l) {
        const Point out = lane(ray.origin, l) - centre, normal = lane(ray.normal, l);
        ASSERT_NEAR(length(out), record.radius, 1e-6 * 4);  // the coordinates' size
        ASSERT_GE(dot(normal, lane(ray.direction, l)), 0);
        ASSERT_NEAR(std::abs(dot(normal, out)), record.radius, 1e-5);
        outwards += dot(normal, out) > 0;
        mean = mean + out * (1 / record.radius);
        ++all;
      }
    }
    // Five standard deviations: 0.5 of one of a pair, 0.58 of a coordinate of a sphere's points.
    const double root = std::sqrt(static_cast<double>(all));
    EXPECT_NEAR(outwards, all / 2, 5 * 0.5 * root);
    for (const double sum : {mean.x, mean.y, mean.z}) EXPECT_NEAR(sum, 0, 5 * 0.58 * root);
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
