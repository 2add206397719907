// Reflectance of surfaces against closed forms, and ghosts against matrices of paraxial optics.
#include "optics/ghosts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "optics/image_quality.h"
#include "optics/reflectance.h"
#include "unit/lib/optics/test_lenses.h"

namespace tessera::optics::ghost_tests {
namespace {

constexpr double kGreen = 550;
const Coating kMagnesiumFluoride{1.38, kGreen / 4 / 1.38};  // a quarter of a wavelength

/// All surfaces of the lens but its stop get a layer of magnesium fluoride.
Prescription with_layers(Prescription lens) {
  for (Surface& s : lens.surfaces) {
    if (!s.stop) s.coating = kMagnesiumFluoride;
  }
  return lens;
}
LensSystem focused(const Prescription& lens, const LensUse& use = {}) {
  std::vector<Fault> faults;
  const auto system = LensSystem::focus(lens, use, faults);
  for (const Fault& fault : faults) ADD_FAILURE() << fault.message;
  return *system;
}
/// The double Gauss, whose surfaces are bare or have a layer.
LensSystem double_gauss_in_focus(bool has_layers) {
  return focused(has_layers ? with_layers(double_gauss()) : double_gauss());
}

TEST(Reflectance, IsFresnelsAtBareGlass) {
  EXPECT_NEAR(reflectance(1, 1.5, {}, 1, kGreen), 0.04, 1e-15);
  EXPECT_EQ(reflectance(1.5, 1.5, {}, 0.7, kGreen), 0);
  // At Brewster's angle the part of one polarisation is 0, and that of the other is known.
  const double n = 1.5, brewster = std::cos(std::atan(n));
  EXPECT_NEAR(reflectance(1, n, {}, brewster, kGreen), std::pow((n * n - 1) / (n * n + 1), 2) / 2, 1e-14);
  // From glass, beyond the critical angle.
  EXPECT_EQ(reflectance(1.5, 1, {}, 0.5, kGreen), 1);
  EXPECT_NEAR(reflectance(1, 1.5, {}, 1e-6, kGreen), 1, 1e-5);
}

TEST(Reflectance, OfAQuarterWaveIsTheClosedForm) {
  for (const double n : {1.5, 1.8}) {
    const double squared = kMagnesiumFluoride.index * kMagnesiumFluoride.index;
    EXPECT_NEAR(reflectance(1, n, kMagnesiumFluoride, 1, kGreen), std::pow((n - squared) / (n + squared), 2),
                1e-14);
    // Half a wavelength is as if there were no layer, at any angle for which it is half a wavelength.
    const double cosine = 0.8, inside = std::sqrt(1 - (1 - cosine * cosine) / squared);
    const Coating half{1.38, kGreen / 2 / 1.38 / inside};
    EXPECT_NEAR(reflectance(1, n, half, cosine, kGreen), reflectance(1, n, {}, cosine, kGreen), 1e-14);
    EXPECT_NEAR(reflectance(1, n, Coating{1.38, 0}, cosine, kGreen), reflectance(1, n, {}, cosine, kGreen),
                1e-14);
  }
}

TEST(Reflectance, IsTheSameFromBothSides) {
  for (const std::optional<Coating>& coating :
       {std::optional<Coating>(), std::optional(kMagnesiumFluoride)}) {
    for (const double cosine : {1.0, 0.9, 0.6, 0.2}) {
      const double behind = std::sqrt(1 - (1 - cosine * cosine) / (1.6 * 1.6));
      EXPECT_NEAR(reflectance(1, 1.6, coating, cosine, 480), reflectance(1.6, 1, coating, behind, 480),
                  1e-14);
    }
  }
}

/// A ray's height and slope, along its way: after a reflection towards the film again, mirrored.
struct Matrix {
  double a = 1, b = 0, c = 0, d = 1;
  Matrix then(const Matrix& m) const {
    return {m.a * a + m.b * c, m.a * b + m.b * d, m.c * a + m.d * c, m.c * b + m.d * d};
  }
};
Matrix gap(double t) { return {1, t, 0, 1}; }
/// Radius above 0 where the middle lies on the side that the ray goes to.
Matrix refraction(double radius, double n, double n_behind) {
  return {1, 0, (n - n_behind) / (radius * n_behind), n / n_behind};
}
Matrix mirror(double radius) { return {1, 0, 2 / radius, 1}; }

TEST(Ghosts, OfASingletAreThoseOfParaxialOptics) {
  const double r1 = 60, r2 = -90, t = 7, n = 1.52, diameter = 0.4;
  const LensSystem lens =
      focused({"", "", {stop(2, diameter), surface(r1, t, n, 20), surface(r2, 0, 1, 20)}});
  const auto ghosts = ghosts_of(lens);
  ASSERT_EQ(ghosts.size(), 1u);
  EXPECT_EQ(ghosts[0].bounce.near_scene, 1u);
  EXPECT_EQ(ghosts[0].bounce.near_film, 2u);
  // Towards the second surface, which the ray sees with its middle behind; back to the first one, whose
  // middle then lies on the side that the ray goes away from, the frame being turned round twice.
  const Matrix way = refraction(r1, 1, n)
                         .then(gap(t))
                         .then(mirror(r2))
                         .then(gap(t))
                         .then(mirror(-r1))
                         .then(gap(t))
                         .then(refraction(r2, n, 1));
  const double behind = -way.a / way.c;  // of rays that come along the axis
  // Rings of the real rays are at most 0.2 mm from the axis: aberrations are below a part in 10^4.
  EXPECT_NEAR(ghosts[0].focus, lens.back_distance() - behind, 1e-3 * std::abs(behind));
  const double spread = std::abs(way.a + way.c * lens.back_distance());
  EXPECT_NEAR(ghosts[0].diameter, diameter * spread, 1e-2 * diameter * spread);
  const double bare = std::pow((n - 1) / (n + 1), 2);
  EXPECT_NEAR(ghosts[0].part, bare * bare, 1e-3 * bare * bare);
}

TEST(Ghosts, AreWeakerWithCoatings) {
  double all[2] = {};
  for (const bool has_layers : {false, true}) {
    const LensSystem lens = double_gauss_in_focus(has_layers);
    const auto ghosts = ghosts_of(lens, kGreen);
    EXPECT_GT(ghosts.size(), 30u);
    for (const Ghost& ghost : ghosts) {
      all[has_layers ? 1 : 0] += ghost.part;
      EXPECT_GT(ghost.diameter, 0);
    }
  }
  EXPECT_GT(all[0], 0.01);
  EXPECT_LT(all[1], all[0] / 5);
}

/// Light that enters a lens is on the film, in ghosts, or lost: never more.
TEST(Ghosts, NoRayBringsMoreLightThanItHas) {
  std::mt19937 engine(5);
  std::uniform_real_distribution<double> number(-1, 1);
  for (const bool has_layers : {false, true}) {
    const LensSystem lens = double_gauss_in_focus(has_layers);
    const auto bounces = lens.bounces(kGreen);
    EXPECT_EQ(bounces.size(), 13u * 12 / 2);  // of 13 surfaces of glass
    int through = 0;
    for (int i = 0; i < 300; ++i) {
      const Vector at{12 * number(engine), 12 * number(engine), lens.front()};
      const Vector direction = unit({0.25 * number(engine), 0.25 * number(engine), -1});
      const Ray ray{at - direction * 20, direction};
      const auto straight = lens.refracted_to_film(ray, kGreen);
      double sum = straight ? straight->part : 0;
      through += straight ? 1 : 0;
      for (const Bounce& bounce : bounces) {
        if (const auto ghost = lens.reflected_to_film(ray, bounce, kGreen)) sum += ghost->part;
      }
      EXPECT_LE(sum, 1);
    }
    EXPECT_GT(through, 50);
  }
}

TEST(Ghosts, RaysGoTheSameWayBack) {
  const LensSystem lens = focused(with_layers(double_gauss()), {.focus = 2000, .f_number = 2});
  std::mt19937 engine(9);
  std::uniform_real_distribution<double> number(-1, 1);
  int found = 0;
  for (const Bounce& bounce : lens.bounces(kGreen)) {
    for (int i = 0; i < 100; ++i) {
      const Vector film{18 * number(engine), 12 * number(engine), 0};
      const Vector at{8 * number(engine), 8 * number(engine), lens.back_distance()};
      const auto out = lens.reflected_to_scene({film, unit(at - film)}, bounce, kGreen);
      if (!out) continue;
      const Ray back{out->ray.origin + out->ray.direction * 5.0, out->ray.direction * -1};
      const auto again = lens.reflected_to_film(back, bounce, kGreen);
      if (!again) continue;  // at the rim of an aperture
      ++found;
      const Vector landed = at_plane(again->ray, 0);
      EXPECT_NEAR(landed.x, film.x, 1e-6);
      EXPECT_NEAR(landed.y, film.y, 1e-6);
      EXPECT_NEAR(again->part, out->part, 1e-9 * out->part);
    }
  }
  EXPECT_GT(found, 500);
}

TEST(Ghosts, TransmittanceIsThatOfTheRayAlongTheAxis) {
  const LensSystem lens = focused(with_layers(double_gauss()));
  const auto ray = lens.refracted_to_film({{0, 0, lens.front() + 10}, {0, 0, -1}}, kGreen);
  ASSERT_TRUE(ray);
  EXPECT_NEAR(ray->part, transmittance(lens, kGreen), 1e-12);
}

}  // namespace
}  // namespace tessera::optics::ghost_tests
