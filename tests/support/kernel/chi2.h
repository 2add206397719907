// Pearson's chi-square test: does a sampler follow the density that it claims? [Pearson 1900; use for BSDFs
// after Nori]
//
//   SphereGrid grid(20, 40);
//   std::vector<double> observed(grid.size() + 1), expected(grid.size() + 1);  // one more: samples without a
//   direction
//   ... ++observed[grid.cell(x, y, z)] ...
//   expected[i] = n * integrate_cell(pdf, grid.bounds(i));
//   EXPECT_GT(chi_square_test(observed, expected).p_value, sidak_level(0.01, kTestsInThisProgram));
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>

namespace tessera::test {

/// Upper regularised incomplete gamma function Q(a, x) for a > 0, x >= 0: series below a + 1, continued
/// fraction above [Abramowitz & Stegun 1964, 6.5.29 and 6.5.31, evaluated by Lentz's method].
inline double regularized_gamma_q(double a, double x) {
  constexpr double kPrecision = 1e-14;
  constexpr int kIterations = 100000;
  if (x <= 0) return 1;
  const double scale = std::exp(a * std::log(x) - x - std::lgamma(a));
  if (x < a + 1) {
    double term = 1 / a, sum = term;
    for (int n = 1; n < kIterations && std::abs(term) > kPrecision * std::abs(sum); ++n) {
      term *= x / (a + n);
      sum += term;
    }
    return 1 - scale * sum;
  }
  constexpr double kTiny = 1e-300;
  double b = x + 1 - a, c = 1 / kTiny, d = 1 / b, fraction = d;
  for (int n = 1; n < kIterations; ++n) {
    const double an = -n * (n - a);
    b += 2;
    d = an * d + b;
    d = 1 / (std::abs(d) < kTiny ? kTiny : d);
    c = b + an / c;
    c = std::abs(c) < kTiny ? kTiny : c;
    fraction *= d * c;
    if (std::abs(d * c - 1) < kPrecision) break;
  }
  return scale * fraction;
}

/// The level for each of `tests` independent tests so that all pass with probability 1 - `level` when nothing
/// is wrong [Sidak 1967].
inline double sidak_level(double level, int tests) { return -std::expm1(std::log1p(-level) / tests); }

struct ChiSquareResult {
  double statistic = 0;
  int degrees_of_freedom = 0;
  double p_value = 1;
};

/// Compares counts with expected counts, cell by cell. Cells that expect less than `min_expected` are pooled,
/// each with the next such cell, so cells should be in an order where neighbours are close. The totals need
/// not agree: a density that does not integrate to one is a finding. A single pool, as of mirrors, tests the
/// total; where nothing is expected there is nothing to test, which no test may pass with: p = 0.
inline ChiSquareResult chi_square_test(std::span<const double> observed, std::span<const double> expected,
                                       double min_expected = 10) {
  ChiSquareResult result;
  int pools = 0;
  double pool_observed = 0, pool_expected = 0;
  double last_observed = 0, last_expected = 0;  // the last pool is held back for the remainder
  const auto add = [&](double o, double e) {
    result.statistic += (o - e) * (o - e) / e;
    ++pools;
  };
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (expected[i] >= min_expected) {
      add(observed[i], expected[i]);
      continue;
    }
    pool_observed += observed[i];
    pool_expected += expected[i];
    if (pool_expected >= min_expected) {
      if (last_expected > 0) add(last_observed, last_expected);
      last_observed = pool_observed;
      last_expected = pool_expected;
      pool_observed = pool_expected = 0;
    }
  }
  last_observed += pool_observed;
  last_expected += pool_expected;
  if (last_expected > 0 || last_observed > 0) add(last_observed, std::max(last_expected, 0.1));
  if (pools == 0) {
    result.p_value = 0;
    return result;
  }
  result.degrees_of_freedom = std::max(pools - 1, 1);
  result.p_value = regularized_gamma_q(0.5 * result.degrees_of_freedom, 0.5 * result.statistic);
  return result;
}

/// A cell of directions: cos(theta) in [z0, z1], azimuth in [phi0, phi1]. Its solid angle is its area.
struct SphereCell {
  double z0 = -1, z1 = 1;
  double phi0 = 0, phi1 = 2 * std::numbers::pi;

  double solid_angle() const { return (z1 - z0) * (phi1 - phi0); }
};

/// The sphere cut into cells of equal solid angle, rows of cos(theta) after rows.
class SphereGrid {
 public:
  SphereGrid(int rows, int columns) : rows_(rows), columns_(columns) {}

  std::size_t size() const { return static_cast<std::size_t>(rows_) * columns_; }

  /// The cell of a unit direction.
  std::size_t cell(double x, double y, double z) const {
    double phi = std::atan2(y, x);
    if (phi < 0) phi += 2 * std::numbers::pi;
    const int row = std::clamp(static_cast<int>(0.5 * (z + 1) * rows_), 0, rows_ - 1);
    const int column = std::clamp(static_cast<int>(0.5 * phi / std::numbers::pi * columns_), 0, columns_ - 1);
    return static_cast<std::size_t>(row) * columns_ + column;
  }

  SphereCell bounds(std::size_t cell) const {
    const int row = static_cast<int>(cell) / columns_, column = static_cast<int>(cell) % columns_;
    return {2.0 * row / rows_ - 1, 2.0 * (row + 1) / rows_ - 1, 2 * std::numbers::pi * column / columns_,
            2 * std::numbers::pi * (column + 1) / columns_};
  }

 private:
  int rows_, columns_;
};

/// Abscissae in (0, 1) and weights of Gauss-Legendre quadrature with four points.
inline constexpr double kGaussPoints[4] = {0.06943184420297371, 0.33000947820757187, 0.66999052179242813,
                                           0.93056815579702629};
inline constexpr double kGaussWeights[4] = {0.17392742256872693, 0.32607257743127307, 0.32607257743127307,
                                            0.17392742256872693};

/// The four quarters of a cell.
inline void split(const SphereCell& cell, SphereCell (&quarters)[4]) {
  const double z = 0.5 * (cell.z0 + cell.z1), phi = 0.5 * (cell.phi0 + cell.phi1);
  quarters[0] = {cell.z0, z, cell.phi0, phi};
  quarters[1] = {cell.z0, z, phi, cell.phi1};
  quarters[2] = {z, cell.z1, cell.phi0, phi};
  quarters[3] = {z, cell.z1, phi, cell.phi1};
}

/// Integral over a cell of `pdf(x, y, z)`, a density over solid angle, by 4x4 Gauss points, refined while a
/// quartering changes the result by more than `tolerance` (absolute), `depth` times at most.
template <class Pdf>
double integrate_cell(const Pdf& pdf, const SphereCell& cell, double tolerance = 1e-6, int depth = 10) {
  const auto gauss = [&](const SphereCell& c) {
    double sum = 0;
    for (int i = 0; i < 4; ++i) {
      const double z = c.z0 + (c.z1 - c.z0) * kGaussPoints[i];
      const double r = std::sqrt(std::max(0.0, 1 - z * z));
      for (int j = 0; j < 4; ++j) {
        const double phi = c.phi0 + (c.phi1 - c.phi0) * kGaussPoints[j];
        sum += kGaussWeights[i] * kGaussWeights[j] * pdf(r * std::cos(phi), r * std::sin(phi), z);
      }
    }
    return sum * c.solid_angle();
  };
  const auto refine = [&](const auto& self, const SphereCell& c, double coarse, double allowed,
                          int left) -> double {
    SphereCell quarters[4];
    split(c, quarters);
    double parts[4], sum = 0;
    for (int i = 0; i < 4; ++i) sum += parts[i] = gauss(quarters[i]);
    if (std::abs(sum - coarse) <= allowed || left == 0) return sum;
    sum = 0;
    for (int i = 0; i < 4; ++i) sum += self(self, quarters[i], parts[i], 0.5 * allowed, left - 1);
    return sum;
  };
  return refine(refine, cell, gauss(cell), tolerance, depth);
}

}  // namespace tessera::test
