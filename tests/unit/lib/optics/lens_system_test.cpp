// Lenses against closed forms, published numbers, and rays that are traced in another way.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "optics/image_quality.h"
#include "optics/lens_system.h"
#include "optics/pupil.h"
#include "unit/lib/optics/test_lenses.h"

namespace tessera::optics {
namespace {

using std::numbers::pi;
using testing::HasSubstr;

/// Smith, Modern Optical Engineering, fourth edition, chapter 6: focal length 101.181, back focus 77.405.
Prescription triplet() {
  return {"triplet",
          "",
          {surface(37.40, 5.90, 1.61272, 29.4), surface(-341.48, 12.93, 1, 29.4),
           surface(-42.65, 2.50, 1.64769, 21.6), surface(36.40, 2.00, 1, 21.6), stop(9.85, 20.6),
           surface(204.52, 5.90, 1.61272, 23.2), surface(-37.05, 0, 1, 23.2)}};
}
/// Smith, Modern Lens Design, page 164, scaled to 16 mm.
Prescription fisheye() {
  return {"fisheye",
          "",
          {surface(48.35984, 1.3336, 1.620, 48.544), surface(18.22896, 11.86176, 1, 33.088),
           surface(120.32304, 1.70464, 1.639, 28.48), surface(13.33584, 17.84784, 1, 21.472),
           surface(15.34112, 3.20864, 1.654, 14.432), surface(70.18832, 8.6232, 1, 13.024),
           stop(2.26608, 9.728), surface(47.12656, 3.50944, 1.517, 9.536),
           surface(-8.3624, 1.55424, 1.805, 9.344), surface(-22.86144, 0.10032, 1, 9.536),
           surface(-35.79616, 1.504, 1.673, 9.536), surface(-24.06464, 0, 1, 10.432)}};
}
/// Behind a stop far enough for any bend.
constexpr double kBefore = 2;
Prescription singlet(double r1, double r2, double thickness, double index, double diameter) {
  return {"singlet",
          "",
          {stop(kBefore, diameter), surface(r1, thickness, index, diameter), surface(r2, 0, 1, diameter)}};
}

LensSystem focused(const Prescription& lens, const LensUse& use = {}) {
  std::vector<Fault> faults;
  const auto system = LensSystem::focus(lens, use, faults);
  for (const Fault& fault : faults) ADD_FAILURE() << fault.message;
  return *system;
}
std::string faults_with(const Prescription& lens, const LensUse& use = {}) {
  std::vector<Fault> faults;
  EXPECT_FALSE(LensSystem::focus(lens, use, faults).has_value());
  std::string all;
  for (const Fault& fault : faults) all += fault.message + "\n";
  return all;
}

TEST(LensSystem, FocalLengthsAreThosePublished) {
  const Paraxial smith = paraxial_of(triplet(), kLineD);
  // The book has six digits.
  EXPECT_NEAR(smith.focal_length(), 101.181, 1e-3);
  EXPECT_NEAR(smith.back_focus(), 77.405, 1e-3);
  EXPECT_NEAR(paraxial_of(double_gauss(), kLineD).focal_length(), 50, 0.05);  // 0.1 %
  EXPECT_NEAR(paraxial_of(fisheye(), kLineD).focal_length(), 16, 0.016);
}

TEST(LensSystem, SingletsHaveTheLensmakersFocalLength) {
  const double r1 = 60, r2 = -90, t = 7, n = 1.52;
  const double power = (n - 1) * (1 / r1 - 1 / r2 + (n - 1) * t / (n * r1 * r2));
  const Paraxial lens = paraxial_of(singlet(r1, r2, t, n, 10), kLineD);
  EXPECT_NEAR(lens.focal_length() * power, 1, 1e-12);
  EXPECT_NEAR(lens.back_focus(), (1 - (n - 1) * t / (n * r1)) / power, 1e-9);
  // The stop stands before the lens, where its image is itself; behind it, the thick lens's equation holds.
  EXPECT_NEAR(lens.entrance_pupil, 0, 1e-12);
  EXPECT_NEAR(lens.exit_pupil, lens.image_of(0), 1e-9);
  EXPECT_NEAR(lens.exit_magnification, lens.magnification(0), 1e-9);
}

TEST(LensSystem, SeidelsSumOfAThinSingletIsTheClosedForm) {
  // [Welford 1986, section 12.4]: for things at infinity.
  const double n = 1.5, f = 100, h = 10, k = 1 / f;
  for (const double shape : {-2.0, -0.5, 0.0, 0.7142857, 1.0, 2.5}) {
    const double c1 = k / (n - 1) * (shape + 1) / 2, c2 = k / (n - 1) * (shape - 1) / 2;
    const double first = n / (n - 1), bend = shape - 2 * (n * n - 1) / (n + 2);
    const double expected = std::pow(h, 4) * std::pow(k, 3) / 4 *
                            (first * first + (n + 2) / (n * (n - 1) * (n - 1)) * bend * bend - n / (n + 2));
    const double r1 = c1 == 0 ? 0 : 1 / c1, r2 = c2 == 0 ? 0 : 1 / c2;
    EXPECT_NEAR(seidel_spherical(singlet(r1, r2, 1e-7, n, 30), h, HUGE_VAL, kLineD), expected,
                1e-6 * expected)
        << shape;
  }
}

TEST(LensSystem, RaysHaveSeidelsAberrationNearTheAxis) {
  // The distance between the marginal and the paraxial focus is f^2 S / (2 h^2), to the second order in h.
  for (const Prescription& lens : {singlet(60, -90, 7, 1.52, 10), triplet(), double_gauss()}) {
    const LensSystem system = focused(lens);
    const double h = 1, f = system.paraxial().focal_length();
    const auto out = system.to_film({{h, 0, system.front() + 10}, {0, 0, -1}}, kLineD);
    ASSERT_TRUE(out);
    const double meets = out->origin.z - out->origin.x * out->direction.z / out->direction.x;
    const double paraxial = system.back_distance() - system.paraxial().back_focus();
    const double expected = f * f * seidel_spherical(lens, h, HUGE_VAL, kLineD) / (2 * h * h);
    EXPECT_NEAR(meets - paraxial, expected, 0.03 * std::abs(expected) + 1e-9) << lens.name;
  }
}

TEST(LensSystem, AsphericTermsAddToSeidelsSum) {
  Prescription lens = singlet(60, -90, 7, 1.52, 10);
  lens.surfaces[1].conic = -0.7, lens.surfaces[1].aspheric = {2e-6, -1e-9};
  const LensSystem system = focused(lens);
  const double h = 1, f = system.paraxial().focal_length();
  const auto out = system.to_film({{h, 0, system.front() + 10}, {0, 0, -1}}, kLineD);
  ASSERT_TRUE(out);
  const double meets = out->origin.z - out->origin.x * out->direction.z / out->direction.x;
  const double paraxial = system.back_distance() - system.paraxial().back_focus();
  const double expected = f * f * seidel_spherical(lens, h, HUGE_VAL, kLineD) / (2 * h * h);
  EXPECT_NEAR(meets - paraxial, expected, 0.03 * std::abs(expected));
}

TEST(LensSystem, APlanoHyperboloidHasNoSphericalAberration) {
  // Parallel light leaves glass of index n through a hyperboloid of conic constant -n^2 to one point.
  const double n = 1.5;
  Prescription lens = singlet(0, -50, 10, n, 40);
  lens.surfaces[2].conic = -n * n;
  const LensSystem system = focused(lens);
  for (const double h : {1.0, 8.0, 19.0}) {
    const auto out = system.to_film({{0, h, system.front() + 10}, {0, 0, -1}}, kLineD);
    ASSERT_TRUE(out);
    EXPECT_NEAR(at_plane(*out, 0).y, 0, 1e-9) << h;
  }
}

TEST(LensSystem, RaysGoTheSameWayBack) {
  const LensSystem system = focused(double_gauss(), {.focus = 2000, .f_number = 2});
  int through = 0;
  for (int i = 0; i < 400; ++i) {
    const Vector from{-15 + 0.07 * i, 8 - 0.05 * i, 0}, to{5 * std::sin(0.3 * i), 5 * std::cos(0.7 * i), 40};
    const Ray start{from, unit(to - from)};
    const auto out = system.to_scene(start, kLineD);
    if (!out) continue;
    ++through;
    const auto back = system.to_film({out->origin + out->direction * 50, out->direction * -1}, kLineD);
    ASSERT_TRUE(back);
    const Vector at = at_plane(*back, 0);
    EXPECT_NEAR(at.x, from.x, 1e-8);
    EXPECT_NEAR(at.y, from.y, 1e-8);
  }
  EXPECT_GT(through, 100);
}

/// A meridional ray by angles alone, as it was done with tables of logarithms [Kingslake 1978, section 2.4]:
/// independent of LensSystem's intersections and refractions. From the film to the scene; heights along x.
struct MeridionalRay {
  double height_at_stop = 0;
  double angle = 0;  // to the axis, in the scene
};
MeridionalRay meridional(const LensSystem& lens, double height, double angle) {
  MeridionalRay result;
  double y = height, z = 0, u = angle;
  const auto& elements = lens.elements();
  for (std::size_t i = elements.size(); i-- > 0;) {
    const Surface& surface = elements[i].surface;
    const double n = surface.behind.index, after = i > 0 ? elements[i - 1].surface.behind.index : 1;
    if (surface.radius == 0) {
      y += (elements[i].z - z) * std::tan(u), z = elements[i].z;
      if (surface.stop) result.height_at_stop = y;
      u = std::asin(n * std::sin(u) / after);
      continue;
    }
    // The centre of curvature lies at z - R on the film's side; the perpendicular from it to the ray.
    const double centre = elements[i].z - surface.radius;
    const double perpendicular = (y + (centre - z) * std::tan(u)) * std::cos(u);
    const double incidence = std::asin(perpendicular / surface.radius);
    const double at = incidence + u;  // angle of the point about the centre
    y = surface.radius * std::sin(at), z = centre + surface.radius * std::cos(at);
    u = at - std::asin(n * perpendicular / (after * surface.radius));
  }
  result.angle = u;
  return result;
}

TEST(LensSystem, DistortionIsThatOfAnIndependentTrace) {
  for (const auto& [lens, film] : {std::pair{triplet(), 20.0}, {double_gauss(), 21.0}, {fisheye(), 19.0}}) {
    const LensSystem system = focused(lens);
    for (const double part : {0.2, 0.5, 0.8, 1.0}) {
      const double height = film * part;
      const auto field = field_point(system, height, {});
      ASSERT_TRUE(field) << lens.name << part;
      double low = -1.2, high = 1.2;  // slopes towards the stop's middle, by bisection of an angle
      for (int i = 0; i < 80; ++i) {
        const double middle = (low + high) / 2;
        const MeridionalRay ray = meridional(system, height, middle);
        // Rays that miss a surface go too far to one side.
        const bool above =
            std::isnan(ray.height_at_stop) || std::isnan(ray.angle) ? middle > -0.1 : ray.height_at_stop > 0;
        (above ? high : low) = middle;
      }
      const MeridionalRay ray = meridional(system, height, (low + high) / 2);
      ASSERT_NEAR(ray.height_at_stop, 0, 1e-6);
      EXPECT_NEAR(field->angle, std::abs(ray.angle), 1e-7) << lens.name;
      EXPECT_NEAR(field->distortion,
                  height / (system.paraxial().focal_length() * std::tan(std::abs(ray.angle))) - 1, 1e-6);
    }
  }
}

/// Light from the scene, counted ray by ray where it lands, has the irradiance that is computed from the
/// film.
TEST(LensSystem, IlluminationIsThatOfLightFromTheScene) {
  const LensSystem system = focused(double_gauss(), {.f_number = 5.6});
  // Parallel light of an angle goes through an area across it; that angle's part of the sky lands on a ring.
  const auto beam = [&](double angle) {
    const Vector direction{-std::sin(angle), 0, -std::cos(angle)};
    constexpr int kSteps = 900;
    const double half = 22, cell = 2 * half / kSteps;
    double through = 0;
    for (int i = 0; i < kSteps * kSteps; ++i) {
      const int column = i % kSteps, row = i / kSteps;
      const Vector at{-half + (column + 0.5) * cell, -half + (row + 0.5) * cell, system.front() + 12};
      if (system.to_film({at, direction}, kLineD)) ++through;
    }
    return through * cell * cell * std::cos(angle);
  };
  const auto angle_at = [&](double height) {
    const auto out = system.unstopped(*principal_ray(system, height, kLineD), kLineD);
    return std::atan2(std::hypot(out->direction.x, out->direction.y), out->direction.z);
  };
  const auto irradiance = [&](double height) {
    const double step = 0.01, low = angle_at(height - step), high = angle_at(height + step);
    return beam(angle_at(height)) * (std::cos(low) - std::cos(high)) / (2 * height * step);
  };
  const double middle = irradiance(0.05);
  for (const double height : {6.0, 12.0, 20.0}) {
    const auto field = field_point(system, height, {});
    ASSERT_TRUE(field);
    EXPECT_NEAR(field->illumination, irradiance(height) / middle, 0.005 * field->illumination) << height;
  }
}

TEST(LensSystem, AxialIrradianceIsThatOfTheConeOfLight) {
  const LensSystem system = focused(triplet());
  // pi sin^2 of the marginal ray's angle behind the lens.
  double low = 0, high = 1;
  for (int i = 0; i < 60; ++i) {
    const double angle = (low + high) / 2;
    (system.to_scene({{0, 0, 0}, {std::sin(angle), 0, std::cos(angle)}}, kLineD) ? low : high) = angle;
  }
  EXPECT_NEAR(axial_irradiance(system), pi * std::pow(std::sin(low), 2), 1e-6);
}

TEST(LensSystem, FocusIsWhereRaysOfAPointMeet) {
  for (const double distance : {400.0, 1000.0, 5000.0}) {
    const LensSystem system = focused(double_gauss(), {.focus = distance, .f_number = 8});
    const Vector point{0, 0, distance};
    for (const double y : {0.5, 1.5, 2.5}) {
      const auto out = system.to_film({point, unit(Vector{0, y, system.front()} - point)}, kLineD);
      ASSERT_TRUE(out);
      EXPECT_NEAR(at_plane(*out, 0).y, 0, 2e-3) << distance;
    }
    EXPECT_NEAR(system.paraxial().image_of(distance - system.front()), system.back_distance(), 0.05);
  }
}

TEST(LensSystem, PupilsHoldAllLightAndLittleElse) {
  for (const LensUse& use :
       {LensUse{}, LensUse{.focus = 700, .f_number = 4}, LensUse{.f_number = 4, .blades = 6}}) {
    for (const auto& [lens, half_width, half_height] :
         {std::tuple{double_gauss(), 18.0, 12.0}, {triplet(), 18.0, 12.0}, {fisheye(), 14.0, 9.3}}) {
      const LensSystem system = focused(lens, use);
      const PupilTable table = pupil_table(system, half_width, half_height);
      constexpr int kPlaces = 12, kSteps = 120;
      int lost = 0, found = 0;
      double worst_waste = 0;
      for (int place = 0; place < kPlaces; ++place) {
        const double part = (place + 0.37) / kPlaces, turn = place * 0.13;
        const Point film{part * half_width * std::cos(turn), part * half_height * std::sin(turn)};
        std::size_t cell = 0;
        double cosine = 1, sine = 0;
        const double radius = std::hypot(film.x, film.y);
        if (table.rings) {
          cell = static_cast<std::size_t>(radius / table.cell_x);
          cosine = film.x / radius, sine = film.y / radius;
        } else {
          cell = static_cast<std::size_t>((film.x - table.first_x) / table.cell_x) +
                 static_cast<std::size_t>((film.y - table.first_y) / table.cell_y) *
                     static_cast<std::size_t>(table.cells_x);
        }
        const PupilNode* const nodes = table.nodes.data() + cell * PupilTable::kNodes;
        const double area = nodes[PupilTable::kNodes - 1].area_before;
        ASSERT_GT(area, 0);
        const double spare = 0.6 * (nodes[PupilTable::kNodes - 1].x - nodes[0].x);
        const double middle = (nodes[PupilTable::kNodes - 1].x + nodes[0].x) / 2, step = 2 * spare / kSteps;
        int inside_and_open = 0;
        for (int i = 0; i < kSteps; ++i) {
          const double x = middle - spare + (i + 0.5) * step;
          const double across = (nodes[PupilTable::kNodes / 2].low + nodes[PupilTable::kNodes / 2].high) / 2;
          for (int j = 0; j < kSteps; ++j) {
            const double y = across - spare + (j + 0.5) * step;
            const Vector from{film.x, film.y, 0}, to{x * cosine - y * sine, x * sine + y * cosine, table.z};
            if (!system.to_scene({from, unit(to - from)}, kLineD)) continue;
            ++found;
            bool inside = false;
            for (int k = 0; k + 1 < PupilTable::kNodes; ++k) {
              const PupilNode &a = nodes[k], &b = nodes[k + 1];
              if (x < a.x || x > b.x) continue;
              const double t = b.x > a.x ? (x - a.x) / (b.x - a.x) : 0;
              inside = y >= a.low + t * (b.low - a.low) && y <= a.high + t * (b.high - a.high);
              if (inside) break;
            }
            inside ? ++inside_and_open : ++lost;
          }
        }
        worst_waste = std::max(worst_waste, 1 - inside_and_open * step * step / area);
      }
      EXPECT_EQ(lost, 0) << lens.name << " of " << found;
      EXPECT_GT(found, 1000);
      // Counted on a grid of some hundred lines, whose own error is a percent.
      EXPECT_LT(worst_waste, use.blades == 0 ? 0.1 : 0.13)
          << lens.name << " f/" << system.use().f_number << " blades " << use.blades;
    }
  }
}

TEST(LensSystem, CoatedSurfacesReflectLess) {
  Prescription lens = singlet(60, -90, 7, 1.52, 10);
  const double bare = std::pow((1.52 - 1) / (1.52 + 1), 2);
  EXPECT_NEAR(transmittance(focused(lens), 550), (1 - bare) * (1 - bare), 1e-12);
  // A quarter of a wave of the root of the index reflects nothing.
  const double index = std::sqrt(1.52);
  for (const std::size_t i : {1, 2}) lens.surfaces[i].coating = Coating{index, 550 / (4 * index)};
  EXPECT_NEAR(transmittance(focused(lens), 550), 1, 1e-12);
  EXPECT_LT(transmittance(focused(lens), 450), 1 - 1e-4);
}

TEST(LensFaults, AreToldAllTogether) {
  Prescription lens = double_gauss();
  lens.surfaces[0].diameter = 120;  // of a sphere of radius 56.655
  lens.surfaces[3].thickness = -1;
  lens.surfaces[6].stop = false;
  const std::string faults = faults_with(lens);
  EXPECT_THAT(faults, HasSubstr("surface 1: an aperture of 120 mm is larger than its element"));
  EXPECT_THAT(faults, HasSubstr("surface 4: a thickness of -1 mm"));
  EXPECT_THAT(faults, HasSubstr("no surface is the aperture stop"));
}

TEST(LensFaults, OverlappingSurfacesAreNamed) {
  Prescription lens = double_gauss();
  lens.surfaces[4].radius = -84.6;  // bends back into the one before it
  lens.surfaces[3].thickness = 0.8;
  EXPECT_THAT(faults_with(lens), HasSubstr("surface 4: it and surface 5 overlap"));
}

TEST(LensFaults, WhatCannotBeFocusedIsSaid) {
  EXPECT_THAT(faults_with(double_gauss(), {.focus = 120}), HasSubstr("nearer than possible"));
  EXPECT_THAT(faults_with(double_gauss(), {.f_number = 0.7}), HasSubstr("is the lens's own"));
  EXPECT_THAT(faults_with(double_gauss(), {.stop_diameter = 60}), HasSubstr("larger than its element"));
  EXPECT_THAT(faults_with(double_gauss(), {.blades = 2}), HasSubstr("3 to 64 blades"));
  EXPECT_THAT(faults_with(double_gauss(), {.focus = NAN}), HasSubstr("focus"));
  EXPECT_THAT(faults_with(singlet(-60, 90, 1, 1.5, 10)), HasSubstr("it casts no image"));
  EXPECT_THAT(faults_with({}), HasSubstr("a lens without surfaces"));
}

TEST(LensFaults, SizesOfNoLensAreRefused) {
  Prescription lens = singlet(60, -90, 7, 1.5, 10);
  EXPECT_THAT(faults_with(lens, {.f_number = 1e9}), HasSubstr("0.001 mm is the least"));
  EXPECT_THAT(faults_with(lens, {.stop_diameter = 1e-9}), HasSubstr("0.001 mm is the least"));
  lens.surfaces.front().diameter = 1e-300;
  lens.surfaces.back().diameter = 1e300;
  lens.surfaces[1].aspheric.assign(17, 0);
  EXPECT_THAT(faults_with(lens), HasSubstr("1e-300 mm is none of a lens"));
  EXPECT_THAT(faults_with(lens), HasSubstr("1e+300 mm is none of a lens"));
  EXPECT_THAT(faults_with(lens), HasSubstr("17 aspheric coefficients; 16 are possible"));
  lens.surfaces.resize(100'000, lens.surfaces.back());
  EXPECT_THAT(faults_with(lens), HasSubstr("a lens of 100000 surfaces; 256 are possible"));
}

TEST(LensSystem, VeryDistantThingsAreAtInfinity) {
  const LensSystem far = focused(double_gauss(), {.focus = 1e300}), infinite = focused(double_gauss());
  EXPECT_EQ(far.back_distance(), infinite.back_distance());
  EXPECT_NEAR(focused(double_gauss(), {.focus = 1e11}).back_distance(), infinite.back_distance(), 1e-6);
}

/// The pupil is a disk as wide as the f-number says, and open all over the film.
TEST(LensSystem, SmallStopsLetTheirLightThrough) {
  for (const double f_number : {22.0, 500.0, 20'000.0}) {
    const LensSystem system = focused(double_gauss(), {.f_number = f_number});
    EXPECT_NEAR(axial_irradiance(system) / (pi / (4 * f_number * f_number)), 1, 0.01) << f_number;
    const PupilTable table = pupil_table(system, 18, 12);
    double least = HUGE_VAL;
    for (std::size_t cell = 0; cell < table.nodes.size(); cell += PupilTable::kNodes)
      least = std::min(least, table.nodes[cell + PupilTable::kNodes - 1].area_before);
    EXPECT_GT(least, 0.7 * table.nodes[PupilTable::kNodes - 1].area_before) << f_number;
  }
}

TEST(LensFaults, TheNearestFocusIsPossible) {
  // The least distance that the message has works, and a little less does not.
  std::vector<Fault> faults;
  double least = 0;
  for (double focus = 150; least == 0; focus += 1) {
    if (LensSystem::focus(double_gauss(), {.focus = focus, .f_number = 8}, faults)) least = focus;
  }
  EXPECT_THAT(faults.front().message,
              HasSubstr(std::to_string(static_cast<int>(least)) + " mm is the least"));
}

TEST(LensSystem, ThinLensesBlurAsTheDepthOfFieldSays) {
  const LensSystem system = focused(double_gauss(), {.focus = 2000, .f_number = 11});
  const double circle = 0.03;
  const DepthOfField depth = depth_of_field(system, circle);
  for (const double end : {depth.near, depth.far}) {
    // The marginal ray of a point on the axis there lands half of the circle from the middle.
    double low = 0, high = 0.2;
    double landed = 0;
    for (int i = 0; i < 50; ++i) {
      const double angle = (low + high) / 2;
      const auto out = system.to_film({{0, 0, end}, {std::sin(angle), 0, -std::cos(angle)}}, kLineD);
      if (out) landed = std::abs(at_plane(*out, 0).x);
      (out ? low : high) = angle;
    }
    EXPECT_NEAR(2 * landed, circle, 0.1 * circle) << end;  // spherical aberration is the rest
  }
}

}  // namespace
}  // namespace tessera::optics
