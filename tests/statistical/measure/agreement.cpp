#include "agreement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "absl/strings/str_cat.h"
#include "measure_text.h"
#include "support/long_form.h"
#include "support/picture/p_values.h"

namespace tessera::test {

namespace {

constexpr std::uint64_t kSeeds[] = {1, 1001, 2001};
constexpr double kSmallestP = 1e-4;
/// Below this, 1 - p is lost in the tails' sums.
constexpr double kLeastTail = 1e-300;

/// A figure of all seeds together.
struct PooledFigure {
  std::string name = {};
  double truth = 0, rounding = 0, largest_error = 0;
  double value = 0, variance = 0, by_freedom = 0;  // sums over seeds

  double mean() const { return value / static_cast<double>(std::size(kSeeds)); }
  double standard_error() const { return std::sqrt(variance) / static_cast<double>(std::size(kSeeds)); }
  double p_value() const {
    // Degrees of freedom of a sum of variances [Satterthwaite 1946].
    const double freedom = by_freedom > 0 ? variance * variance / by_freedom : 1;
    return interval_p_value(mean() - truth, rounding * std::abs(truth) + 1e-9, standard_error(),
                            std::max(1, static_cast<int>(std::min(freedom, 1e5))));
  }
  std::string text() const {
    return absl::StrCat(name, ": ", mean(), " +- ", standard_error(), ", not ", truth);
  }
};

/// Measures a case, and adds its figures. Cases have seeds of their own: those of the same geometry would err
/// alike with the same random numbers.
void measure_case(const MeasuredCase& test, std::uint64_t first_seed, std::vector<PooledFigure>& figures) {
  const std::size_t first = figures.size();
  for (const double truth : test.truths)
    figures.push_back({.truth = truth, .rounding = test.rounding, .largest_error = test.largest_error});
  const auto opened = MeasuredText::open({.scene = scene_with(test.scene, test.medium, test.cd_per_m2),
                                          .meters = test.meters,
                                          .algorithm = test.algorithm,
                                          .is_spectral = test.is_spectral,
                                          .files = test.files});
  ASSERT_TRUE(opened.ok()) << opened.status();
  for (const std::uint64_t seed : kSeeds) {
    const auto measured = (*opened)->measure(test.samples * (long_form() ? 16 : 1), first_seed + seed);
    ASSERT_TRUE(measured.ok()) << measured.status();
    std::size_t k = first;
    for (const client::MeasuredMeter& meter : measured->meters) {
      for (const client::Reading& reading : meter.readings) {
        ASSERT_LT(k, figures.size());
        PooledFigure& pooled = figures[k++];
        const client::Figure& figure = reading.figure;
        const double variance = figure.standard_error * figure.standard_error;
        pooled.name = absl::StrCat(test.name, ": ", meter.name, " ", reading.label);
        pooled.value += figure.value, pooled.variance += variance;
        if (figure.degrees_of_freedom > 0)
          pooled.by_freedom += variance * variance / figure.degrees_of_freedom;
      }
    }
    ASSERT_EQ(k, figures.size());
  }
}

}  // namespace

void expect_agreement(const std::vector<MeasuredCase>& cases) {
  std::vector<PooledFigure> figures;
  std::uint64_t seed = 0;
  for (const MeasuredCase& test : cases) {
    SCOPED_TRACE(test.name);
    measure_case(test, seed, figures);
    seed += 10000;
    if (testing::Test::HasFatalFailure()) return;
  }
  double chi_square = 0;
  for (const PooledFigure& figure : figures) {
    const double p = figure.p_value();
    // The square of a standard normal variable that is as improbable.
    const double z = normal_quantile(std::clamp(p / 2, kLeastTail, 0.5));
    chi_square += z * z;
    EXPECT_LE(figure.standard_error(), figure.largest_error * std::max(std::abs(figure.truth), 1e-3))
        << figure.text();
    EXPECT_GT(p * static_cast<double>(figures.size()), kSmallestP) << figure.text();
  }
  const auto count = static_cast<double>(figures.size());
  const double all = regularized_gamma_q(count / 2, chi_square / 2);
  std::cout << figures.size() << " figures of " << cases.size() << " cases: chi-square " << chi_square
            << ", p " << all << '\n';
  if (all > kSmallestP) return;
  ADD_FAILURE() << "chi-square " << chi_square << " of " << count << " figures";
  for (const PooledFigure& figure : figures) std::cout << figure.text() << ", p " << figure.p_value() << '\n';
}

}  // namespace tessera::test
