#include "optics/hole_diffraction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

namespace tessera::optics {
namespace {

using std::numbers::pi;

/// Fresnel's integral over the hole, by Simpson's rule.
double irradiance_by_quadrature(double fresnel_number, double radius) {
  constexpr int kSteps = 20000;
  const double u = 2 * pi * fresnel_number;
  std::complex<double> sum;
  for (int i = 0; i <= kSteps; ++i) {
    const double at = static_cast<double>(i) / kSteps;
    const double weight = i == 0 || i == kSteps ? 1 : 2 + 2 * (i % 2);
    sum += weight * std::polar(1.0, u / 2 * at * at) * std::cyl_bessel_j(0, u * radius * at) * at;
  }
  return u * u * std::norm(sum / (3.0 * kSteps));
}

TEST(HoleDiffraction, IsFresnelsIntegral) {
  for (const double fresnel_number : {0.03, 0.5, 1.0, 3.7, 36.0}) {
    for (const double radius : {0.0, 0.3, 0.8, 0.9999, 1.0, 1.0001, 1.5, 4.0}) {
      const double expected = irradiance_by_quadrature(fresnel_number, radius);
      EXPECT_NEAR(hole_irradiance(fresnel_number, radius), expected, 1e-7 * (1 + expected))
          << fresnel_number << " at " << radius;
    }
    // In the middle, zones cancel in pairs.
    EXPECT_NEAR(hole_irradiance(fresnel_number, 0), 4 * std::pow(std::sin(pi * fresnel_number / 2), 2), 1e-9);
  }
}

std::vector<double> even_radii(double most, int count) {
  std::vector<double> radii;
  for (int i = 1; i <= count; ++i) radii.push_back(most * i / count);
  return radii;
}

/// The light within radii, summed up over thin rings; all of it is 1, so that energy is conserved.
TEST(HoleDiffraction, LightWithinRadiiIsTheSumOfRings) {
  for (const double fresnel_number : {0.1, 1.0, 3.7, 36.0}) {
    const double most = std::max(1.5, 10 / fresnel_number);
    const std::vector<double> radii = even_radii(most, 40), parts = light_within_hole(fresnel_number, radii);
    constexpr int kRings = 80000;
    double sum = 0, worst = 0;
    for (int i = 0; i < kRings; ++i) {
      const double radius = most * (i + .5) / kRings;
      sum += 2 * radius * hole_irradiance(fresnel_number, radius) * most / kRings;
      if ((i + 1) % (kRings / 40) != 0) continue;
      const auto ring = static_cast<std::size_t>((i + 1) / (kRings / 40) - 1);
      worst = std::max(worst, std::abs(parts[ring] - sum));
    }
    EXPECT_LT(worst, 3e-4) << fresnel_number;
    EXPECT_NEAR(sum + light_beyond_hole(fresnel_number, most), 1, 3e-4) << fresnel_number;
  }
}

TEST(HoleDiffraction, TendsToAirysPatternAndToTheShadow) {
  // The light within a radius is 1 - J0^2 - J1^2 [Born & Wolf 1999, section 8.5.2].
  constexpr double kFar = 1e-3;
  const std::vector<double> radii = even_radii(10 / kFar, 200), airy = light_within_hole(kFar, radii);
  for (std::size_t i = 0; i < radii.size(); i += 7) {
    const double v = 2 * pi * kFar * radii[i];
    const double dark = std::pow(std::cyl_bessel_j(0, v), 2) + std::pow(std::cyl_bessel_j(1, v), 2);
    EXPECT_NEAR(airy[i], 1 - dark, 2e-4) << v;
  }
  // The first dark ring, 1.22 wavelengths times distance over diameter.
  EXPECT_NEAR(hole_irradiance(kFar, 1.21967 / (2 * kFar)) / hole_irradiance(kFar, 0), 0, 1e-6);
  const std::vector<double> within = even_radii(1.5, 15),
                            shadow = light_within_hole(kMostFresnelNumber, within);
  for (std::size_t i = 0; i < within.size(); ++i)
    EXPECT_NEAR(shadow[i], std::min(within[i] * within[i], 1.0), i == 9 ? 3e-2 : 5e-3) << within[i];
}

}  // namespace
}  // namespace tessera::optics
