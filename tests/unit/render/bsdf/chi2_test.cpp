// The chi-square helper itself: a test of samplers must be able to fail.
#include "support/kernel/chi2.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace tessera::test {
namespace {

TEST(ChiSquare, IncompleteGammaMatchesTables) {
  EXPECT_NEAR(regularized_gamma_q(0.5, 0.5 * 3.841458820694124), 0.05,
              1e-12);  // chi-square, 1 degree of freedom
  EXPECT_NEAR(regularized_gamma_q(5, 0.5 * 18.307038053275146), 0.05, 1e-12);   // 10
  EXPECT_NEAR(regularized_gamma_q(50, 0.5 * 135.80672317102676), 0.01, 1e-10);  // 100
  EXPECT_NEAR(regularized_gamma_q(1, 3), std::exp(-3.0), 1e-14);
}

TEST(ChiSquare, SidakLevelsMultiplyToTheWhole) {
  EXPECT_NEAR(std::pow(1 - sidak_level(0.01, 300), 300), 0.99, 1e-12);
}

/// p-value of 10^5 uniform directions, of which a share is moved to the upper half, against the uniform
/// density.
double p_value_with_bias(double share) {
  constexpr int kSamples = 100000;
  const SphereGrid grid(10, 20);
  std::vector<double> observed(grid.size()), expected(grid.size());
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform;
  for (int i = 0; i < kSamples; ++i) {
    double z = 2 * uniform(random) - 1;
    if (uniform(random) < share) z = std::abs(z);
    const double r = std::sqrt(1 - z * z), phi = 2 * std::numbers::pi * uniform(random);
    ++observed[grid.cell(r * std::cos(phi), r * std::sin(phi), z)];
  }
  const auto density = [](double, double, double) { return 0.25 / std::numbers::pi; };
  for (std::size_t i = 0; i < grid.size(); ++i)
    expected[i] = kSamples * integrate_cell(density, grid.bounds(i));
  return chi_square_test(observed, expected).p_value;
}

TEST(ChiSquare, AcceptsTheTruthAndRejectsABias) {
  EXPECT_GT(p_value_with_bias(0), 0.01);
  EXPECT_LT(p_value_with_bias(0.05), 1e-4);
}

TEST(ChiSquare, SamplesWhereNoneAreExpectedAreRejected) {
  const std::vector<double> observed{1000, 1000, 50, 0}, expected{1025, 1025, 0, 0};
  EXPECT_LT(chi_square_test(observed, expected).p_value, 1e-10);
}

TEST(ChiSquare, IntegratesPeaks) {
  // A cosine lobe of high power: (n + 1) / (2 pi) cos^n over the sphere is 1.
  const auto lobe = [](double, double, double z) {
    return z > 0 ? 501 / (2 * std::numbers::pi) * std::pow(z, 500) : 0;
  };
  const SphereGrid grid(4, 4);
  double sum = 0;
  for (std::size_t i = 0; i < grid.size(); ++i) sum += integrate_cell(lobe, grid.bounds(i));
  EXPECT_NEAR(sum, 1, 1e-5);
}

}  // namespace
}  // namespace tessera::test
