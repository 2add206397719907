// Irradiance estimated through light sampling, against formulas.
#include <gtest/gtest.h>

#include "render/sampling/sphere_map.h"
#include "statistical/light/lamps.h"

namespace tessera::render::TESSERA_ISA {
namespace {

struct Estimate {
  double mean[3] = {0, 0, 0};
  double deviation[3] = {0, 0, 0};  // standard error of the mean
};

/// Irradiance on a surface at `at` with normal `n`, light by light; with `cosine_known`, lights are
/// sampled in proportion to the cosine.
Estimate irradiance(const Lamp& lamp, Point at, Point n, int samples_a_light = 100000,
                    bool cosine_known = false) {
  Estimate e;
  const Receiver from = cosine_known ? Receiver(wide(at), wide(n)) : Receiver(wide(at));
  for (std::size_t light = 0; light < lamp.table.lights.size(); ++light) {
    if (lamp.table.lights[light].same_as >= 0) continue;
    Random random(static_cast<unsigned>(11 + light));
    double sum[3] = {}, squares[3] = {};
    for (int i = 0; i < samples_a_light; i += kWidth) {
      const LightSample s =
          sample_light(lamp.table, Int(static_cast<int>(light)), from, random.next_2d(), Mask::all());
      for (int l = 0; l < kWidth; ++l) {
        const double cosine = s.valid.bits() >> l & 1 ? std::max(0.0, dot(lane(s.wi, l), n)) : 0;
        for (int c = 0; c < 3; ++c) {
          const double x = cosine > 0 ? s.radiance.c[c].lane(l) * cosine / s.pdf.lane(l) : 0;
          sum[c] += x;
          squares[c] += x * x;
        }
      }
    }
    for (int c = 0; c < 3; ++c) {
      const double mean = sum[c] / samples_a_light;
      e.mean[c] += mean;
      e.deviation[c] =
          std::hypot(e.deviation[c],
                     std::sqrt(std::max(0.0, squares[c] / samples_a_light - mean * mean) / samples_a_light));
    }
  }
  return e;
}

/// Five standard deviations of the estimate (one test in 10^6 by chance), and the rounding of floats (sums
/// are double).
void expect_irradiance(const Estimate& e, const double (&expected)[3]) {
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(e.mean[c], expected[c], 5 * e.deviation[c] + 2e-6 * expected[c]) << c;
}
void expect_irradiance(const Estimate& e, double per_radiance) {
  expect_irradiance(
      e, {kLampRadiance[0] * per_radiance, kLampRadiance[1] * per_radiance, kLampRadiance[2] * per_radiance});
}

constexpr double kPi64 = std::numbers::pi;

TEST(LightIrradiance, Quad) {
  // Form factor from a point to a rectangle parallel to its surface, one corner above it [Howell, C-3...
  // "differential planar element to finite parallel rectangle"].
  const double a = 1.5, b = 0.7, h = 1.2;
  const double x = a / h, y = b / h, rx = std::sqrt(1 + x * x), ry = std::sqrt(1 + y * y);
  const double factor = (x / rx * std::atan(y / rx) + y / ry * std::atan(x / ry)) / (2 * kPi64);
  const Lamp quad =
      mesh_lamp("quad", {{0, 0, h}, {0, b, h}, {a, b, h}, {a, 0, h}}, {0, 1, 2, 0, 2, 3}, false);
  expect_irradiance(irradiance(quad, {0, 0, 0}, {0, 0, 1}), kPi64 * factor);
  // Nothing arrives at the back, everything from a two-sided one.
  expect_irradiance(irradiance(quad, {0, 0, 2 * h}, {0, 0, -1}), 0);
  const Lamp both = mesh_lamp("quad", {{0, 0, h}, {0, b, h}, {a, b, h}, {a, 0, h}}, {0, 1, 2, 0, 2, 3}, true);
  expect_irradiance(irradiance(both, {0, 0, 2 * h}, {0, 0, -1}), kPi64 * factor);
  // The same with the receiver's cosine, and from its two halves.
  expect_irradiance(irradiance(quad, {0, 0, 0}, {0, 0, 1}, 100000, true), kPi64 * factor);
  const Lamp one = mesh_lamp("half", {{0, 0, h}, {0, b, h}, {a, b, h}}, {0, 1, 2}, false);
  const Lamp other = mesh_lamp("half", {{0, 0, h}, {a, b, h}, {a, 0, h}}, {0, 1, 2}, false);
  for (const bool cosine_known : {false, true}) {
    Estimate sum = irradiance(one, {0, 0, 0}, {0, 0, 1}, 100000, cosine_known);
    const Estimate more = irradiance(other, {0, 0, 0}, {0, 0, 1}, 100000, cosine_known);
    for (int c = 0; c < 3; ++c) {
      sum.mean[c] += more.mean[c];
      sum.deviation[c] = std::hypot(sum.deviation[c], more.deviation[c]);
    }
    expect_irradiance(sum, kPi64 * factor);
  }
}

TEST(LightIrradiance, SolidAngleAndCosineLeaveLittleNoise) {
  // A lamp as wide as it is far: one sample's deviation by area is 0.5 of the mean, by solid angle 0.3.
  const Lamp quad =
      mesh_lamp("quad", {{-1, -1, 1}, {-1, 1, 1}, {1, 1, 1}, {1, -1, 1}}, {0, 1, 2, 0, 2, 3}, false);
  const Estimate e = irradiance(quad, {0.1, 0.2, 0}, {0, 0, 1}, 100000, true);
  EXPECT_LT(e.deviation[0] * std::sqrt(1e5), 0.2 * e.mean[0]);
}

TEST(LightIrradiance, Sphere) {
  const Point centre{1, 2, 3};
  const double radius = 0.8;
  const Lamp sphere =
      quadric_lamp("sphere", ShapeKind::kSphere, sphere_record(0.8f), placed(centre), false, false);
  for (const Point at : {Point{0, 0, 0}, Point{1, 2, 3.81}, Point{-900, 500, 3}}) {
    SCOPED_TRACE(at.x);
    const Point n = unit(centre - at);
    const double distance = length(centre - at);
    // The float radius and centre differ from these by a part in 10^7; at 1 % of a radius from the surface
    // that is 1e-5 of the clearance.
    expect_irradiance(irradiance(sphere, at, n), kPi64 * std::pow(radius / distance, 2));
  }
  // Tilted, with the whole sphere above the horizon.
  const Point tilted = unit(unit(centre) + cross(unit(centre), {1, 0, 0}) * 0.5);
  expect_irradiance(irradiance(sphere, {0, 0, 0}, tilted),
                    kPi64 * std::pow(radius / length(centre), 2) * dot(tilted, unit(centre)));
}

TEST(LightIrradiance, InsideOfASphere) {
  const Lamp inward =
      quadric_lamp("inward", ShapeKind::kSphere, sphere_record(2), placed({1, 2, 3}), true, false);
  expect_irradiance(irradiance(inward, {1.5, 2.2, 1.9}, unit({0.3, 1, 0.2})), kPi64);
  const Lamp outward =
      quadric_lamp("outward", ShapeKind::kSphere, sphere_record(2), placed({1, 2, 3}), false, false);
  expect_irradiance(irradiance(outward, {1.5, 2.2, 1.9}, unit({0.3, 1, 0.2})), 0);
  // A point of the surface may be outside by rounding, and sees all of the inside.
  const Point inwards = unit({-0.3, 0.4, -0.7});
  for (const double beyond : {-2e-7, 0.0, 2e-7}) {
    const Point at = Point{1, 2, 3} - inwards * (2 + beyond);
    expect_irradiance(irradiance(inward, at, inwards), kPi64);
  }
}

TEST(LightIrradiance, SqueezedSphereAgreesWithQuadrature) {
  const Map map = placed({1, 2, 3}, {0.5, 1, 1.6});
  const Lamp egg = quadric_lamp("egg", ShapeKind::kSphere, sphere_record(1), map, false, false);
  // Uniform directions over a cone that holds the egg, first hit only counts as it is convex.
  const Point axis = unit(egg.centre);
  const Point x = unit(cross({0, 0, 1}, axis)), y = cross(axis, x);
  const double z_low = 0.8;
  double sum = 0;
  constexpr int kSteps = 1000;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const double z = z_low + (1 - z_low) * (i + 0.5) / kSteps, phi = 2 * kPi64 * (j + 0.5) / kSteps,
                   r = std::sqrt(1 - z * z);
      const Point w = axis * z + x * (r * std::cos(phi)) + y * (r * std::sin(phi));
      if (!egg.hits({0, 0, 0}, w).empty()) sum += z;
    }
  }
  const double expected = sum / kSteps / kSteps * 2 * kPi64 * (1 - z_low);
  const Estimate e = irradiance(egg, {0, 0, 0}, axis);
  // The outline crosses about 4 * kSteps of the kSteps^2 cells, each off by half at most, at random: far
  // below 1e-3.
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(e.mean[c], kLampRadiance[c] * expected,
                5 * e.deviation[c] + 1e-3 * kLampRadiance[c] * expected);
  }
}

TEST(LightIrradiance, Disk) {
  QuadricRecord q;
  q.radius = 1.3f;
  q.height = 0.5f;
  const Map map = placed({1, 2, 3});
  const Point normal = map.vector({0, 0, 1});
  const double h = 1.7;
  const Point at = map.point({0, 0, 0.5}) + normal * h;
  const auto cap = [h](double r) { return r * r / (r * r + h * h); };
  const Lamp disk = quadric_lamp("disk", ShapeKind::kDisk, q, map, false, false);
  expect_irradiance(irradiance(disk, at, normal * -1), kPi64 * cap(1.3));
  q.inner_radius = 0.6f;
  q.phi_max = static_cast<float>(kPi64);
  q.partial = 1;
  const Lamp half_ring = quadric_lamp("half ring", ShapeKind::kDisk, q, map, false, false);
  expect_irradiance(irradiance(half_ring, at, normal * -1), kPi64 * (cap(1.3) - cap(0.6)) / 2);
}

/// A single record in a table.
Lamp delta_lamp(LightRecord record) {
  Lamp lamp;
  std::copy(kLampRadiance.begin(), kLampRadiance.end(), record.radiance);
  lamp.table.lights = {record};
  return lamp;
}

TEST(LightIrradiance, PointAndSpot) {
  LightRecord record;
  record.position[2] = 2;
  const Lamp point = delta_lamp(record);
  for (const double height : {0.0, 1.0, 1.99}) {
    expect_irradiance(irradiance(point, {0, 0, height}, {0, 0, 1}, 16), 1 / ((2 - height) * (2 - height)));
  }
  // At 45 degrees, sqrt(8) away.
  expect_irradiance(irradiance(point, {2, 0, 0}, {0, 0, 1}, 16), std::sqrt(0.5) / 8);

  record.kind = LightKind::kSpot;
  record.direction[2] = -1;
  record.cos_outer = 0.6f;
  record.cos_inner = 0.9f;
  const Lamp spot = delta_lamp(record);
  const auto at_cosine = [&](double cosine) {
    const Point at{2 * std::tan(std::acos(cosine)), 0, 0};
    const Estimate e = irradiance(spot, at, {0, 0, 1}, 16);
    return e.mean[0] / (kLampRadiance[0] * cosine * cosine * cosine / 4);
  };
  EXPECT_NEAR(at_cosine(1), 1, 1e-6);
  EXPECT_NEAR(at_cosine(0.95), 1, 1e-5);
  EXPECT_NEAR(at_cosine(0.75), 0.5, 1e-5);                            // smoothstep(1/2)
  EXPECT_NEAR(at_cosine(0.675), 0.25 * 0.25 * (3 - 2 * 0.25), 1e-5);  // smoothstep(1/4)
  EXPECT_EQ(at_cosine(0.59), 0);

  record.cos_inner = record.cos_outer;
  const Lamp hard = delta_lamp(record);
  EXPECT_GT(irradiance(hard, {2 * std::tan(std::acos(0.61)), 0, 0}, {0, 0, 1}, 16).mean[0], 0);
  EXPECT_EQ(irradiance(hard, {2 * std::tan(std::acos(0.59)), 0, 0}, {0, 0, 1}, 16).mean[0], 0);
}

/// Irradiance under a sphere of radiance 1, `h` radii from its centre, on a surface whose normal has this
/// angle with the direction to it, less than all of the sphere being above it [Snyder et al. 1998, after
/// Lagarde & de Rousiers 2014].
double cut_by_horizon(double h, double angle) {
  const double x = std::sqrt(h * h - 1), y = -x / std::tan(angle), s = std::sin(angle);
  const double root = std::sqrt(1 - y * y);
  return (std::cos(angle) * std::acos(y) - x * s * root) / (h * h) + std::atan(s * root / x);
}

TEST(LightIrradiance, SoftPoint) {
  const Point centre{1, 2, 3};
  const double radius = 0.8;
  const Lamp lamp = soft_lamp("soft point", LightKind::kSoftPoint, centre, 0.8f);
  const auto turned = [](Point towards, double angle) {
    const Point axis = unit(towards), across = unit(cross(axis, {1, 0, 0}));
    return axis * std::cos(angle) + across * std::sin(angle);
  };
  for (const Point at : {Point{0, 0, 0}, Point{1, 2, 3.81}, Point{-900, 500, 3}}) {
    SCOPED_TRACE(at.x);
    const double h = length(centre - at) / radius, limb = std::asin(1 / h);
    // All of it above the horizon, straight or tilted: the point's.
    for (const double angle : {0.0, 0.9 * (kPi64 / 2 - limb)}) {
      expect_irradiance(irradiance(lamp, at, turned(centre - at, angle)),
                        std::cos(angle) / std::pow(h * radius, 2));
    }
    // Below it in part. Near to the surface, floats know the clearance to 1e-5 of it, and far away they know
    // the angle to 1e-7, of a limb of 1e-3.
    for (const double part : {-0.5, 0.0, 0.5}) {
      const double angle = kPi64 / 2 + part * limb;
      const double expected = cut_by_horizon(h, angle) / (kPi64 * radius * radius);
      const Estimate e = irradiance(lamp, at, turned(centre - at, angle));
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(e.mean[c], kLampRadiance[c] * expected,
                    5 * e.deviation[c] + 1e-3 * kLampRadiance[c] * expected);
      }
    }
    // All of it below.
    expect_irradiance(irradiance(lamp, at, turned(centre - at, kPi64 / 2 + 1.01 * limb)), 0);
  }
}

TEST(LightIrradiance, WithinASoftPoint) {
  // One wall, everywhere: of half of the radiance that is seen from outside.
  const Lamp lamp = soft_lamp("soft point", LightKind::kSoftPoint, {1, 2, 3}, 2);
  for (const Point at : {Point{1.5, 2.2, 1.9}, Point{1, 2, 3}})
    expect_irradiance(irradiance(lamp, at, unit({0.3, 1, 0.2})), 1 / (2 * std::pow(2, 2)));
}

TEST(LightIrradiance, TinySoftLightsArePoints) {
  for (const bool spot : {false, true}) {
    LightRecord record;
    record.kind = spot ? LightKind::kSpot : LightKind::kPoint;
    record.position[2] = 2;
    record.direction[2] = -1;
    record.cos_outer = 0.6f;
    record.cos_inner = 0.9f;
    const Lamp point = delta_lamp(record);
    record.kind = spot ? LightKind::kSoftSpot : LightKind::kSoftPoint;
    for (const float radius : {1e-4f, 1e-9f, 1e-30f}) {
      record.radius = radius;
      const Lamp soft = delta_lamp(record);
      for (const Point at : {Point{0, 0, 0}, Point{1.5, 0.3, -0.2}, Point{0, 0, 1.9}}) {
        const Estimate expected = irradiance(point, at, {0, 0, 1}, 16),
                       found = irradiance(soft, at, {0, 0, 1});
        // Over a sphere, profiles differ from their middle by no more than their curvature, 100 at most,
        // times the square of its angle: 1e-3 on the axis, where the profile is flat, 1e-4 elsewhere.
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(found.mean[c], expected.mean[c], 5 * found.deviation[c] + 1e-5 * expected.mean[c]);
      }
    }
  }
}

TEST(LightIrradiance, SoftSpot) {
  // A hard cone of 45 degrees, held against the directions of rays: where the edge of the cone passes the
  // sphere there is all of a point's light, or none.
  LightRecord record;
  record.kind = LightKind::kSoftSpot;
  record.position[2] = 4;
  record.direction[2] = -1;
  record.radius = 0.5f;
  record.cos_outer = record.cos_inner = std::sqrt(0.5f);
  const Lamp spot = delta_lamp(record);
  record.kind = LightKind::kSoftPoint;
  const Lamp point = delta_lamp(record);
  const auto part_at = [&](double x) {
    return irradiance(spot, {x, 0, 0}, {0, 0, 1}).mean[0] / irradiance(point, {x, 0, 0}, {0, 0, 1}).mean[0];
  };
  // On the floor at x = 4 the edge goes through the centre; its rays pass the sphere beyond 0.5 * sqrt(2).
  EXPECT_NEAR(part_at(0), 1, 1e-6);
  EXPECT_NEAR(part_at(3.2), 1, 1e-6);
  EXPECT_EQ(part_at(4.8), 0);
  // Half of the sphere, but for 2 % by the receiver's cosine and 1 % by the curve of the cone.
  EXPECT_NEAR(part_at(4), 0.5, 0.03);
}

TEST(LightIrradiance, Distant) {
  LightRecord record;
  record.kind = LightKind::kDistant;
  record.direction[0] = 0.6f;
  record.direction[2] = -0.8f;
  expect_irradiance(irradiance(delta_lamp(record), {100, -5, 3}, {0, 0, 1}, 16), 0.8);
  expect_irradiance(irradiance(delta_lamp(record), {100, -5, 3}, {0, 0, -1}, 16), 0);
}

TEST(LightIrradiance, UniformEnvironment) {
  const Affine turned = placed({0, 0, 0}).affine();
  const Lamp uniform =
      environment_lamp("uniform", *build_environment({}, EnvironmentMapping::kUniform, 1, turned));
  expect_irradiance(irradiance(uniform, {3, 2, 1}, unit({1, 2, 3})), kPi64);
  // The same radiance everywhere from images.
  TextureImage image;
  image.width = image.height = 4;
  for (int i = 0; i < 16; ++i) image.texels32.insert(image.texels32.end(), {1.0f, 1.5f, 2.0f, 1.0f});
  for (const auto mapping :
       {EnvironmentMapping::kEqualAreaOctahedral, EnvironmentMapping::kLatitudeLongitude}) {
    const Lamp lamp = environment_lamp("constant image", *build_environment(image, mapping, 2, turned));
    expect_irradiance(irradiance(lamp, {3, 2, 1}, unit({1, 2, 3})), kPi64);
  }
}

TEST(LightIrradiance, ThroughAPortal) {
  // The rectangle of the test "Quad", as a window onto a sky of radiance 1.
  const double a = 1.5, b = 0.7, h = 1.2;
  const double x = a / h, y = b / h, rx = std::sqrt(1 + x * x), ry = std::sqrt(1 + y * y);
  const double factor = (x / rx * std::atan(y / rx) + y / ry * std::atan(x / ry)) / (2 * kPi64);
  const Environment sky = *build_environment({}, EnvironmentMapping::kUniform, 1, placed({0, 0, 0}).affine());
  const Lamp down = environment_lamp("window", through_portal(sky, {0, 0, h}, {0, b, 0}, {a, 0, 0}));
  expect_irradiance(irradiance(down, {0, 0, 0}, {0, 0, 1}), kPi64 * factor);
  expect_irradiance(irradiance(down, {0, 0, 2 * h}, {0, 0, -1}), 0);
  // Radiance along a direction agrees with samples.
  const auto seen = [&](Point from, Point w) {
    return environment_radiance(down.table, 0, wide(from), wide(unit(w)), Mask::all()).c[1].lane(0);
  };
  EXPECT_EQ(seen({0, 0, 0}, {0.5, 0.3, h}), kLampRadiance[1]);
  EXPECT_EQ(seen({0, 0, 0}, {-0.01, 0.3, h}), 0);
  EXPECT_EQ(seen({0, 0, 0}, {0.5, 0.71, h}), 0);
  EXPECT_EQ(seen({0, 0, 2 * h}, {0.5, 0.3, -h}), 0);
  EXPECT_EQ(seen({0, 0, 2 * h}, {0.5, 0.3, h}), 0);
}

TEST(LightIrradiance, Cylinder) {
  // From the middle of its axis, a wall of radius r from -h to h is seen under elevations up to atan(h / r);
  // a surface across the axis gets pi sin^2 of it, here from above only.
  QuadricRecord q;
  q.radius = 0.8f;
  q.z_min = -0.6f;
  q.z_max = 0.6f;
  const Map at = placed({1, 2, 3});
  const Lamp wall = quadric_lamp("wall", ShapeKind::kCylinder, q, at, true, false);
  const double sine2 = 0.36 / (0.36 + 0.64);
  // A patch facing along the axis: integral of sin(elevation) cos(elevation) over azimuths and elevations.
  expect_irradiance(irradiance(wall, {1, 2, 3}, at.vector({0, 0, 1})), kPi64 * sine2);
}

TEST(LightIrradiance, ProjectionAndGoniometric) {
  LightRecord record;
  record.kind = LightKind::kProjection;
  record.position[2] = 2;
  // Down: light space has z = -z, x = x, y = -y.
  record.vertices[0] = 1, record.vertices[4] = -1, record.vertices[8] = -1;
  record.tan_x = 0.8f;
  record.tan_y = 0.5f;
  record.profile = kEvenScreen;
  const Lamp even = delta_lamp(record);
  // The same all over the screen, and nothing beside it.
  for (const Point at : {Point{0, 0, 0}, Point{1.5, -0.9, 0}, Point{-0.3, 0.99, 0}}) {
    expect_irradiance(irradiance(even, at, {0, 0, 1}, 16), 0.25);
  }
  expect_irradiance(irradiance(even, {1.61, 0, 0}, {0, 0, 1}, 16), 0);
  expect_irradiance(irradiance(even, {0, 1.01, 0}, {0, 0, 1}, 16), 0);
  expect_irradiance(irradiance(even, {0, 0, 4}, {0, 0, -1}, 16), 0);
  // Plain: as a point light within the picture.
  record.profile = kPlainProfile;
  const Lamp plain = delta_lamp(record);
  record.kind = LightKind::kPoint;
  const Lamp point = delta_lamp(record);
  record.kind = LightKind::kGoniometric;
  const Lamp goniometric = delta_lamp(record);
  for (const Point at : {Point{0, 0, 0}, Point{1.5, -0.9, 0}}) {
    const Estimate expected = irradiance(point, at, {0, 0, 1}, 16);
    expect_irradiance(irradiance(plain, at, {0, 0, 1}, 16), expected.mean);
    expect_irradiance(irradiance(goniometric, at, {0, 0, 1}, 16), expected.mean);
  }
}

TEST(LightIrradiance, LinearSpot) {
  LightRecord record;
  record.kind = LightKind::kSpot;
  record.position[2] = 2;
  record.direction[2] = -1;
  record.profile = kLinearAngle;
  record.cos_outer = std::cos(0.8f);
  record.cos_inner = std::cos(0.3f);
  const Lamp spot = delta_lamp(record);
  for (const auto& [angle, part] : {std::pair{0.0, 1.0}, {0.29, 1.0}, {0.55, 0.5}, {0.7, 0.2}, {0.81, 0.0}}) {
    const double cosine = std::cos(angle);
    const Estimate e = irradiance(spot, {2 * std::tan(angle), 0, 0}, {0, 0, 1}, 16);
    // acos of a float cosine near 1 is off by 1e-7 / sin(0.3).
    EXPECT_NEAR(e.mean[0] / (kLampRadiance[0] * cosine * cosine * cosine / 4), part, 5e-6) << angle;
  }
}

TEST(LightIrradiance, SmallBrightSpotInAnEnvironment) {
  // A sun of one texel in 128 x 128, 10^6 times brighter than the sky: its solid angle is 4 pi / 128^2.
  constexpr int kSize = 128, kX = 80, kY = 50;
  TextureImage image;
  image.width = image.height = kSize;
  for (int i = 0; i < kSize * kSize; ++i) {
    const float v = i == kY * kSize + kX ? 1e6f : 1.0f;
    image.texels32.insert(image.texels32.end(), {v, v, v, 1.0f});
  }
  const Lamp lamp = environment_lamp(
      "sun",
      *build_environment(image, EnvironmentMapping::kEqualAreaOctahedral, 1, placed({0, 0, 0}).affine()));

  // Mean direction over the texel, by midpoints.
  Point sun;
  constexpr int kSteps = 16;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const Vec2 uv = {static_cast<float>((kX + (i + 0.5) / kSteps) / kSize),
                       static_cast<float>((kY + (j + 0.5) / kSteps) / kSize)};
      sun = sun + lane(direction_from_octahedral(uv), 0) * (1.0 / (kSteps * kSteps));
    }
  }
  const Point towards = placed({0, 0, 0}).vector(sun);
  for (const Point n : {unit(towards), unit(unit(towards) + cross(unit(towards), {1, 0, 0}))}) {
    const Estimate e = irradiance(lamp, {0, 0, 0}, n);
    const double expected = (1e6 - 1) * 4 * kPi64 / (kSize * kSize) * dot(n, towards) + kPi64;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(e.mean[c], expected, 5 * e.deviation[c] + 1e-5 * expected);
    // Importance sampling: the deviation of one sample is below the mean itself.
    EXPECT_LT(e.deviation[0] * std::sqrt(100000.0), e.mean[0]);
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
