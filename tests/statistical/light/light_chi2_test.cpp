// Do the lights sample the directions that their densities claim?
#include <gtest/gtest.h>

#include "statistical/light/lamps.h"
#include "support/kernel/chi2.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// A lamp seen from a point that no part of it turns its back on, so that the density integrates to 1.
struct View {
  const Lamp* lamp;
  Point reference;
  Point normal = {};  // the receiver's, if it has one

  Receiver receiver() const {
    Receiver result(wide(reference), wide(normal));
    result.time = lamp->time;
    return result;
  }
};

/// Directions around an axis: all within the cosine `z_low` of it are told apart.
class Focus {
 public:
  Focus(Point axis, double z_low) : z_(unit(axis)), z_low_(z_low), grid_(20, 40) {
    x_ = unit(cross(std::abs(z_.x) > 0.5 ? Point{0, 1, 0} : Point{1, 0, 0}, z_));
    y_ = cross(z_, x_);
  }
  std::size_t size() const { return grid_.size(); }
  std::size_t cell(Point w) const {
    const double z = dot(w, z_);
    return grid_.cell(dot(w, x_), dot(w, y_), 2 * (z - z_low_) / (1 - z_low_) - 1);
  }
  test::SphereCell bounds(std::size_t cell) const {
    test::SphereCell c = grid_.bounds(cell);
    c.z0 = z_low_ + 0.5 * (c.z0 + 1) * (1 - z_low_);
    c.z1 = z_low_ + 0.5 * (c.z1 + 1) * (1 - z_low_);
    return c;
  }
  Point direction(double x, double y, double z) const { return x_ * x + y_ * y + z_ * z; }

 private:
  Point x_, y_, z_;
  double z_low_;
  test::SphereGrid grid_;
};

/// The densities of 16 directions, each over all that it meets of the lamp.
std::array<double, kWidth> densities(const View& view, const std::array<Point, kWidth>& w) {
  const Lamp& lamp = *view.lamp;
  const Receiver reference = view.receiver();
  const Vec3 directions = wide_lanes(w);
  std::array<double, kWidth> sum{};
  const auto add = [&](Vec3 points, Vec3 normals, Mask active) {
    const Float pdf = light_pdf(lamp.table, Int(0), reference, directions, points, normals, active);
    for (std::size_t l = 0; l < kWidth; ++l) sum[l] += pdf.lane(static_cast<int>(l));
  };
  if (lamp.environment) {
    add(directions, directions, Mask::all());
    return sum;
  }
  std::array<std::vector<LampHit>, kWidth> hits;
  std::size_t most = 0;
  for (std::size_t l = 0; l < kWidth; ++l)
    most = std::max(most, (hits[l] = lamp.hits(view.reference, w[l])).size());
  for (std::size_t i = 0; i < most; ++i) {
    std::array<Point, kWidth> points{}, normals{};
    std::uint32_t active = 0;
    for (std::size_t l = 0; l < kWidth; ++l) {
      if (i >= hits[l].size()) continue;
      points[l] = hits[l][i].p;
      normals[l] = hits[l][i].n;
      active |= 1u << l;
    }
    add(wide_lanes(points), wide_lanes(normals), Mask::from_bits(active));
  }
  return sum;
}

/// Probability of a cell, by the midpoints of a fine grid: where an edge of the emitter crosses the cell it
/// crosses about 64 of 4096 parts, each wrong by half at most and at random, which leaves a tenth of a per
/// cent of the cell's probability.
double probability(const View& view, const Focus& focus, const test::SphereCell& cell) {
  constexpr int kSteps = 64;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double z = cell.z0 + (cell.z1 - cell.z0) * (i + 0.5) / kSteps;
    const double r = std::sqrt(std::max(0.0, 1 - z * z));
    for (int j = 0; j < kSteps; j += kWidth) {
      std::array<Point, kWidth> w;
      for (int l = 0; l < kWidth; ++l) {
        const double phi = cell.phi0 + (cell.phi1 - cell.phi0) * (j + l + 0.5) / kSteps;
        w[static_cast<std::size_t>(l)] = focus.direction(r * std::cos(phi), r * std::sin(phi), z);
      }
      for (const double d : densities(view, w)) sum += d;
    }
  }
  return sum * cell.solid_angle() / (kSteps * kSteps);
}

/// Light from everywhere.
bool surrounds(const Lamp& lamp) {
  return lamp.environment && (lamp.table.environments.empty() || lamp.table.environments[0].portal_area == 0);
}

/// The smallest cosine to the lamp's centre among sampled directions, a little widened.
double lowest_cosine(const View& view, Point axis) {
  if (surrounds(*view.lamp)) return -1;
  Random random(7);
  double lowest = 1;
  for (int i = 0; i < 200; ++i) {
    const LightSample s =
        sample_light(view.lamp->table, Int(0), view.receiver(), random.next_2d(), Mask::all());
    for (int l = 0; l < kWidth; ++l) {
      if (s.valid.bits() >> l & 1) lowest = std::min(lowest, dot(unit(lane(s.wi, l)), axis));
    }
  }
  return std::max(-1.0, 1 - (1 - lowest) * 1.1);
}

constexpr int kLightSamples = 160000;

void check(const View& view, int tests) {
  SCOPED_TRACE(view.lamp->name);
  const Lamp& lamp = *view.lamp;
  const Point towards = lamp.centre - view.reference;
  const Point axis = surrounds(lamp) || length(towards) < 1e-3 ? Point{0, 0, 1} : unit(towards);
  const Focus focus(axis, lowest_cosine(view, axis));
  std::vector<double> observed(focus.size() + 1), expected(focus.size() + 1);

  Random random(1);
  for (int i = 0; i < kLightSamples; i += kWidth) {
    const LightSample s = sample_light(lamp.table, Int(0), view.receiver(), random.next_2d(), Mask::all());
    const std::uint32_t valid = s.valid.bits();
    for (int l = 0; l < kWidth; ++l)
      ++observed[valid >> l & 1 ? focus.cell(unit(lane(s.wi, l))) : focus.size()];
  }

  double total = 0;
  for (std::size_t i = 0; i < focus.size(); ++i) {
    const double p = probability(view, focus, focus.bounds(i));
    expected[i] = p * kLightSamples;
    total += p;
  }
  expected[focus.size()] = std::max(0.0, 1 - total) * kLightSamples;
  // Edges of the emitter leave a tenth of a per cent of one cell in ten or so, with either sign; far below
  // this.
  EXPECT_NEAR(total, 1, 1e-3);
  const auto result = test::chi_square_test(observed, expected);
  EXPECT_GT(result.degrees_of_freedom, 20);
  EXPECT_GT(result.p_value, test::sidak_level(0.01, tests))
      << "chi2 " << result.statistic << " dof " << result.degrees_of_freedom;
}

void check_all(const std::vector<View>& views) {
  for (const View& view : views) check(view, static_cast<int>(views.size()));
}

TEST(LightChi2, Triangle) {
  const std::vector<Point> corners = {{-1, 0.5, 2}, {1.2, -0.3, 2.5}, {0.1, 1.5, 3}};
  const Lamp down = mesh_lamp("one-sided", corners, {0, 2, 1}, false);
  const Lamp both = mesh_lamp("two-sided", corners, {0, 1, 2}, true);
  check_all({{&down, {0, 0, 0}}, {&down, {3, -2, 1}}, {&both, {0.2, 0.5, 2.2}}, {&both, {0.3, 0.2, 30}}});
}

TEST(LightChi2, Rectangle) {
  const Point corner{-1, 0.5, 2}, x{1.6, 0.4, -0.8}, y = cross(Point{0.3, 0.2, 0.7}, x);
  const std::vector<Point> corners = {corner, corner + x, corner + x + y, corner + y};
  const Lamp lamp = mesh_lamp("rectangle", corners, {0, 1, 2, 2, 3, 0}, true);
  ASSERT_EQ(lamp.table.lights[0].kind, LightKind::kRectangle);
  const Point middle = corner + (x + y) * 0.5, out = unit(cross(x, y));
  check_all({{&lamp, {0, 0, 0}},
             {&lamp, {0, 0, 0}, unit(middle)},
             {&lamp, {1, 3, -1}, unit({-1, 0.1, 0.05})},
             {&lamp, middle + out * 0.03 + x * 0.1, unit(out * -1 + x)},
             {&lamp, middle + out * 12 + x, unit(x * -1)},   // small, and sampled by solid angle
             {&lamp, middle + out * 60 + x * 30, out * -1},  // small enough to be sampled by area
             {&lamp, corner + x * 1.001 + out * 0.4, unit(x * -1)}});
}

TEST(LightChi2, SphereFromOutside) {
  const Lamp sphere =
      quadric_lamp("sphere", ShapeKind::kSphere, sphere_record(0.8f), placed({1, 2, 3}), false, false);
  check_all({{&sphere, {0, 0, 0}},
             {&sphere, {1, 2, 2.15}},       // just above the surface
             {&sphere, {-200, 100, 50}}});  // half-angle of a fifth of a degree
}

TEST(LightChi2, SphereFromInside) {
  const Lamp inward =
      quadric_lamp("inward", ShapeKind::kSphere, sphere_record(2), placed({1, 2, 3}), true, false);
  check_all({{&inward, {1, 2, 3}}, {&inward, {1.5, 2.2, 1.9}}});
}

TEST(LightChi2, SoftPoint) {
  const Lamp lamp = soft_lamp("soft point", LightKind::kSoftPoint, {1, 2, 3}, 0.8f);
  check_all({{&lamp, {0, 0, 0}},
             {&lamp, {1, 2, 2.15}},       // just above the surface
             {&lamp, {1.3, 1.8, 2.7}},    // inside
             {&lamp, {1, 2, 3}},          // the centre
             {&lamp, {-200, 100, 50}}});  // half-angle of a fifth of a degree
}

TEST(LightChi2, CutAndSqueezedSpheres) {
  // Points of view without a limb: there the density by area grows without bound, and the grid would not
  // integrate it.
  QuadricRecord cut = sphere_record(1);
  cut.z_min = 0.5f;
  cut.phi_max = 4;
  cut.partial = 1;
  const Map at = placed({1, 2, 3}), squeezed = placed({1, 2, 3}, {0.5, 1, 1.6});
  const Lamp cap = quadric_lamp("cap", ShapeKind::kSphere, cut, at, false, true);
  const Lamp egg = quadric_lamp("egg", ShapeKind::kSphere, sphere_record(1), squeezed, true, false);
  check_all({{&cap, at.point({0.2, 0.1, 3})},
             {&cap, {1, 2, 3}},
             {&egg, {1, 2, 3}},
             {&egg, squeezed.point({0.3, 0.5, -0.4})}});
}

TEST(LightChi2, Disk) {
  QuadricRecord whole, sector;
  whole.radius = sector.radius = 1.3f;
  whole.height = sector.height = -0.5f;
  sector.inner_radius = 0.6f;
  sector.phi_max = 4.2f;
  sector.partial = 1;
  const Lamp disk = quadric_lamp("disk", ShapeKind::kDisk, whole, placed({1, 2, 3}), true, true);
  const Lamp ring = quadric_lamp("sector of a ring, squeezed", ShapeKind::kDisk, sector,
                                 placed({1, 2, 3}, {1, 0.6, 1}), false, true);
  check_all({{&disk, {0, 0, 0}}, {&disk, {1, 2, 3.2}}, {&ring, {0, 0, 0}}, {&ring, {5, 5, 5}}});
}

TEST(LightChi2, Cylinder) {
  // From within: towards the outline the density grows without bound, and the grid would not integrate it.
  QuadricRecord whole, cut;
  whole.radius = cut.radius = 0.7f;
  whole.z_min = cut.z_min = -0.5f;
  whole.z_max = cut.z_max = 1.2f;
  cut.phi_max = 2.5f;
  cut.partial = 1;
  const Map at = placed({1, 2, 3}), squeezed = placed({1, 2, 3}, {0.5, 1, 1.6});
  const Lamp both = quadric_lamp("cylinder", ShapeKind::kCylinder, whole, at, false, true);
  const Lamp inward = quadric_lamp("squeezed cylinder", ShapeKind::kCylinder, whole, squeezed, true, false);
  const Lamp sheet = quadric_lamp("cut cylinder", ShapeKind::kCylinder, cut, squeezed, false, true);
  check_all({{&both, at.point({0.1, 0.2, -0.3})},
             {&both, at.point({0.1, -0.3, -2})},
             {&inward, squeezed.point({0.1, -0.2, 0.3})},
             {&sheet, squeezed.point({0, -0.1, 0})}});
}

TEST(LightChi2, Portals) {
  const Affine turned = placed({0, 0, 0}, {2, 2, 2}).affine();
  const auto window = [](Environment e) {
    return through_portal(std::move(e), {-1, 0.5, 2}, {2, 0.5, 0}, {0.3, -1.5, 0.2});
  };
  Lamp uniform =
      environment_lamp("uniform", window(*build_environment({}, EnvironmentMapping::kUniform, 1, turned)));
  Lamp mapped = environment_lamp(
      "octahedral",
      window(*build_environment(noise_image(8, 8, 3), EnvironmentMapping::kEqualAreaOctahedral, 1, turned)));
  uniform.centre = mapped.centre = {0.15, 0, 2.1};
  check_all({{&uniform, {0, 0, 0}}, {&uniform, {3, 1, 1}}, {&mapped, {0.5, -1, 0.5}}});
}

TEST(LightChi2, CompensatedEnvironments) {
  const Affine turned = placed({0, 0, 0}, {2, 2, 2}).affine();
  const auto compensated = [&](EnvironmentMapping mapping) {
    return *build_environment(noise_image(16, 16, 3), mapping, 1, turned, true);
  };
  const Lamp octahedral =
      environment_lamp("octahedral", compensated(EnvironmentMapping::kEqualAreaOctahedral));
  const Lamp latlong = environment_lamp("latlong", compensated(EnvironmentMapping::kLatitudeLongitude));
  check_all({{&octahedral, {0, 0, 0}}, {&latlong, {0, 0, 0}}});
}

TEST(LightChi2, Environments) {
  const Affine turned = placed({0, 0, 0}, {2, 2, 2}).affine();
  const Affine mirrored = placed({0, 0, 0}, {1, 1, -1}).affine();
  const Lamp uniform =
      environment_lamp("uniform", *build_environment({}, EnvironmentMapping::kUniform, 1, turned));
  const Lamp octahedral = environment_lamp(
      "octahedral",
      *build_environment(noise_image(8, 8, 3), EnvironmentMapping::kEqualAreaOctahedral, 1, turned));
  const Lamp latlong = environment_lamp(
      "latitude-longitude",
      *build_environment(noise_image(9, 5, 4), EnvironmentMapping::kLatitudeLongitude, 1, mirrored));
  check_all({{&uniform, {0, 0, 0}}, {&octahedral, {1, 2, 3}}, {&latlong, {0, 0, 0}}});
}

/// Moments of a way on which things are turned, stretched and brought closer.
struct Moments {
  std::vector<Lamp> lamps;
  std::vector<View> views;

  Moments(const std::function<Lamp()>& still, Point from, Point normal = {}) {
    const Map start = placed({0.5, -0.2, 1}), end = placed({-0.4, 0.3, 2}, {1.7, 0.8, 1.2});
    for (const double time : {0.0, 0.4, 1.0}) lamps.push_back(moved(still(), start, end, time));
    for (const Lamp& lamp : lamps) views.push_back({&lamp, from, normal});
  }
};

TEST(LightChi2, MovingTriangleAndRectangle) {
  const auto triangle = [] {
    return mesh_lamp("triangle", {{-1, 0.5, 2}, {1.2, -0.3, 2.5}, {0.1, 1.5, 3}}, {0, 1, 2}, true);
  };
  const auto rectangle = [] {
    const Point corner{-1, 0.5, 2}, x{1.6, 0.4, -0.8}, y = cross(Point{0.3, 0.2, 0.7}, x);
    return mesh_lamp("rectangle", {corner, corner + x, corner + x + y, corner + y}, {0, 1, 2, 2, 3, 0}, true);
  };
  check_all(Moments(triangle, {0, 0, 0}).views);
  check_all(Moments(rectangle, {0.2, 0.4, 0.1}, unit({0.3, 0.5, 1})).views);
}

TEST(LightChi2, MovingSpheres) {
  // From inside, where there is no limb, and from outside while it is not stretched.
  check_all(Moments(
                [] {
                  return quadric_lamp("inward", ShapeKind::kSphere, sphere_record(4), placed({1, 1, 1}), true,
                                      false);
                },
                {0.4, 0.2, 1})
                .views);
  const auto outside = [] {
    return quadric_lamp("sphere", ShapeKind::kSphere, sphere_record(0.8f), placed({1, 2, 3}), false, false);
  };
  const Map start = placed({0.5, -0.2, 1}), end = placed({-0.4, 0.3, 2}, {2, 2, 2});
  const Lamp first = moved(outside(), start, end, 0.25), later = moved(outside(), start, end, 0.75);
  check_all({{&first, {0, 0, 0}}, {&later, {-6, 3, 1}}});
}

TEST(LightChi2, MovingDiskCylinderAndSoftPoint) {
  QuadricRecord ring, tube;
  ring.radius = 1.3f, ring.inner_radius = 0.6f, ring.height = -0.5f;
  ring.phi_max = 4.2f, ring.partial = 1;
  tube.radius = 3, tube.z_min = -2, tube.z_max = 2.5f;
  check_all(Moments(
                [&] {
                  return quadric_lamp("ring", ShapeKind::kDisk, ring, placed({1, 2, 3}), false, true);
                },
                {0, 0, 0})
                .views);
  check_all(Moments(
                [&] {
                  return quadric_lamp("tube", ShapeKind::kCylinder, tube, placed({0, 0, 0}), true, true);
                },
                {0.1, 0.3, 1.2})
                .views);
  const Map start = placed({0.5, -0.2, 1}), end = placed({-1.5, 0.3, 2});
  const Lamp soft = moved(soft_lamp("soft point", LightKind::kSoftPoint, {1, 2, 3}, 0.8f), start, end, 0.6);
  check_all({{&soft, {0, 0, 0}}, {&soft, soft.centre}});
}

TEST(LightChi2, MovingEnvironment) {
  const Map start = placed({0, 0, 0});
  // The middle of two rotations is none: directions are squeezed there, and densities with them.
  const Map end{{start.m[4], start.m[5], start.m[6], 0, -start.m[0], -start.m[1], -start.m[2], 0, start.m[8],
                 start.m[9], start.m[10], 0}};
  const Lamp sky = moved(
      environment_lamp("octahedral", *build_environment(noise_image(8, 8, 3),
                                                        EnvironmentMapping::kEqualAreaOctahedral, 1, {})),
      start, end, 0.3);
  check_all({{&sky, {1, 2, 3}}});
}

/// A patch of two triangles that are bent, and how it stands later.
Lamp deforming_lamp(double time) {
  const std::vector<Point> keys[3] = {{{-1, -1, 2}, {1, -1, 2.2}, {1, 1, 2}, {-1, 1, 2.3}},
                                      {{-1, -0.8, 2.5}, {1.5, -1, 2}, {1, 1.4, 2.1}, {-1.2, 1, 2}},
                                      {{-0.5, -0.8, 2.1}, {0.9, -1.3, 1.8}, {0.7, 0.4, 2.6}, {-1.2, 0.5, 2}}};
  const auto before = static_cast<std::size_t>(std::min(time * 2, 1.0));
  const double part = time * 2 - static_cast<double>(before);
  std::vector<Point> now;
  for (std::size_t i = 0; i < 4; ++i)
    now.push_back(keys[before][i] * (1 - part) + keys[before + 1][i] * part);
  const std::vector<std::uint32_t> triangles = {0, 1, 2};
  // The triangles that rays meet, and the centre, are those of the moment.
  Lamp lamp = mesh_lamp(absl::StrCat("deforming, at ", time), now, triangles, true);
  ShapeRecord& mesh = lamp.shapes->shapes[1];
  mesh.flags |= kDeforms;
  mesh.key_segments = 2;
  lamp.shapes->vertices.resize(static_cast<std::size_t>(mesh.first_vertex));
  for (const std::vector<Point>& key : keys) {
    for (const Point& p : key)
      lamp.shapes->vertices.push_back(
          {{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)}});
  }
  lamp.table.lights.clear();
  append_area_lights(*lamp.shapes, 1, kLampRadiance, true, -1, lamp.table);
  lamp.time = static_cast<float>(time);
  return lamp;
}

TEST(LightChi2, TriangleOfAMeshThatDeforms) {
  const Lamp first = deforming_lamp(0), early = deforming_lamp(0.3), late = deforming_lamp(0.8);
  for (const Lamp* lamp : {&first, &early, &late})
    ASSERT_EQ(lamp->table.lights[0].kind, LightKind::kDeformingTriangle);
  check_all({{&first, {0, 0, 0}}, {&early, {0, 0, 0}}, {&early, {2, 1, 0.5}}, {&late, {0, 0, 0}}});
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
