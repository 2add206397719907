// Pixel filters: samples against the density, weights against the filter itself, and the table against the
// formula.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "render/film/filter_sample.h"
#include "render/film/filter_value.h"
#include "support/kernel/chi2.h"

namespace tessera::render::TESSERA_ISA {
namespace {

struct Filter {
  std::string name;
  FilterSpec spec;
};

std::vector<Filter> filters() {
  const auto spec = [](FilterKind kind, float rx, float ry) {
    FilterSpec s;
    s.kind = kind;
    s.radius_x = rx;
    s.radius_y = ry;
    return s;
  };
  std::vector<Filter> all = {{"box", spec(FilterKind::kBox, 0.5f, 0.5f)},
                             {"wide box", spec(FilterKind::kBox, 1.5f, 0.7f)},
                             {"triangle", spec(FilterKind::kTriangle, 2, 1)},
                             {"gaussian", spec(FilterKind::kGaussian, 1.5f, 2)},
                             {"mitchell", spec(FilterKind::kMitchell, 2, 2)},
                             {"lanczos", spec(FilterKind::kLanczos, 4, 3)},
                             {"narrow gaussian", spec(FilterKind::kGaussian, 3, 3)}};
  all.back().spec.sigma = 0.1f;
  return all;
}

double formula_integral(const FilterSpec& spec, double radius) {
  constexpr int kSteps = 100000;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i)
    sum += evaluate_filter(spec, radius * (2 * (i + 0.5) / kSteps - 1), radius);
  return sum * 2 * radius / kSteps;
}

TEST(PixelFilterChi2, SamplesFollowTheFiltersMagnitude) {
  constexpr int kSamples = 1 << 19, kCells = 64;
  const std::vector<Filter> all = filters();
  for (const Filter& filter : all) {
    const PixelFilterRecord record = PixelFilterRecord::build(filter.spec);
    // Both axes, and their joint distribution in coarser cells.
    std::vector<double> x(kCells), y(kCells), joint(256), share_x(kCells), share_y(kCells), share_joint(256);
    std::mt19937 random(5);
    double weights = 0;
    for (int i = 0; i < kSamples; i += kWidth) {
      alignas(64) float u[kWidth], v[kWidth];
      for (int l = 0; l < kWidth; ++l)
        u[l] = static_cast<float>(random() >> 8) * 0x1p-24f,
        v[l] = static_cast<float>(random() >> 8) * 0x1p-24f;
      const FilterSample s = sample_filter(record, {Float::load(u), Float::load(v)});
      for (int l = 0; l < kWidth; ++l) {
        const double a = s.offset.x.lane(l) / record.x.radius, b = s.offset.y.lane(l) / record.y.radius;
        ASSERT_LE(std::max(std::abs(a), std::abs(b)), 1 + 1e-6) << filter.name;
        const auto cell = [](double t, int cells) {
          return std::min(static_cast<std::size_t>((t + 1) / 2 * cells), static_cast<std::size_t>(cells - 1));
        };
        ++x[cell(a, kCells)];
        ++y[cell(b, kCells)];
        ++joint[cell(a, 16) * 16 + cell(b, 16)];
        weights += s.weight.lane(l);
      }
    }
    // |f| of the formula, over each cell: 64 midpoints, none of which the table's 256 bins share.
    const auto shares = [&](double radius, std::vector<double>& share) {
      double total = 0;
      for (std::size_t c = 0; c < share.size(); ++c) {
        for (int k = 0; k < 64; ++k) {
          share[c] += std::abs(evaluate_filter(
              filter.spec,
              radius *
                  (2 * (static_cast<double>(c) + (k + 0.5) / 64) / static_cast<double>(share.size()) - 1),
              radius));
        }
        total += share[c];
      }
      for (double& s : share) s /= total;
    };
    shares(record.x.radius, share_x);
    shares(record.y.radius, share_y);
    std::vector<double> coarse_x(16), coarse_y(16);
    shares(record.x.radius, coarse_x);
    shares(record.y.radius, coarse_y);
    for (std::size_t i = 0; i < 256; ++i) share_joint[i] = kSamples * coarse_x[i / 16] * coarse_y[i % 16];
    for (std::size_t i = 0; i < kCells; ++i) share_x[i] *= kSamples, share_y[i] *= kSamples;
    const double level = test::sidak_level(0.01, static_cast<int>(3 * all.size()));
    EXPECT_GT(test::chi_square_test(x, share_x).p_value, level) << filter.name;
    EXPECT_GT(test::chi_square_test(y, share_y).p_value, level) << filter.name;
    EXPECT_GT(test::chi_square_test(joint, share_joint).p_value, level) << filter.name;
    // Weights average to 1. Lanczos, the widest of them, has weights of +-1.9: five standard errors.
    EXPECT_NEAR(weights / kSamples, 1, 5 * 2.0 / std::sqrt(double{kSamples})) << filter.name;
  }
}

TEST(PixelFilterChi2, ValuesIntegrateToOneAndAreTheFormula) {
  for (const Filter& filter : filters()) {
    const PixelFilterRecord record = PixelFilterRecord::build(filter.spec);
    for (const FilterAxis* axis : {&record.x, &record.y}) {
      const double integral = formula_integral(filter.spec, axis->radius);
      constexpr int kSteps = 4096;
      double sum = 0, peak = 0, worst = 0;
      for (int i = 0; i < kSteps; ++i) {
        const double at = axis->radius * (2 * (i + 0.5) / kSteps - 1);
        const double value = filter_value(record.kind, *axis, static_cast<float>(at)),
                     exact = evaluate_filter(filter.spec, at, axis->radius) / integral;
        sum += value;
        peak = std::max(peak, std::abs(exact));
        worst = std::max(worst, std::abs(value - exact));
      }
      EXPECT_NEAR(sum * 2 * axis->radius / kSteps, 1, 1e-3) << filter.name;
      // Steps of a 256th of the width: half a step times the steepest slope. Sigma 0.1 in a radius of 3 rises
      // to its peak within 6 steps; the others within 30 or more.
      EXPECT_LT(worst / peak, filter.spec.sigma < 0.2f ? 0.09 : 0.025) << filter.name;
    }
  }
}

/// The value that light tracing splats and the weight of camera samples times their density are the same
/// function: between two numbers u lies the integral of value over weight.
TEST(PixelFilterChi2, WeightTimesDensityIsTheValue) {
  for (const Filter& filter : filters()) {
    const PixelFilterRecord record = PixelFilterRecord::build(filter.spec);
    const FilterAxis& axis = record.x;
    const bool table = !axis.cdf.empty();
    const float weight_y = sample_filter(record, {Float(0.5f), Float(0.5f)}).weight.lane(0) /
                           (table ? axis.weight[axis.weight.size() / 2] : 1.0f);
    for (std::size_t bin = 0; bin < 256; ++bin) {
      // Within one bin of the table, where the value is constant; closed forms are constant or linear, so
      // that the midpoint is exact as well.
      const float begin = table ? axis.cdf[bin] : static_cast<float>(bin) / 256,
                  end = table ? axis.cdf[bin + 1] : static_cast<float>(bin + 1) / 256;
      if (end - begin < 1e-3f) continue;  // too few digits
      const auto sample = [&](float part) {
        return sample_filter(record, {Float(begin + (end - begin) * part), Float(0.5f)});
      };
      const FilterSample low = sample(0.25f), high = sample(0.75f);
      const double x0 = low.offset.x.lane(0), x1 = high.offset.x.lane(0);
      const double value = filter_value(record.kind, axis, static_cast<float>((x0 + x1) / 2));
      // u and offsets are floats near 1, and half of a bin is 5e-4 of u or more: 2^-24 / 5e-4 = 1.2e-4,
      // twice.
      EXPECT_NEAR(value * (x1 - x0) / (low.weight.lane(0) / weight_y), 0.5 * (double{end} - begin),
                  2.5e-4 * (end - begin))
          << filter.name << ", bin " << bin;
    }
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
