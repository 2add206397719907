#include "support/ztest.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace tessera::test {
namespace {

constexpr double kXyzFromRgb[3][3] = {
    {0.412453, 0.357580, 0.180423}, {0.212671, 0.715160, 0.072169}, {0.019334, 0.119193, 0.950227}};
// Variances below this are not believed: fireflies that a reference has not met.
constexpr double kLeastVariance = 1e-4;

std::vector<double> xyz_of(const std::vector<double>& rgb) {
  std::vector<double> xyz(rgb.size());
  for (std::size_t i = 0; i < rgb.size(); i += 3) {
    for (int r = 0; r < 3; ++r) {
      xyz[i + r] =
          kXyzFromRgb[r][0] * rgb[i] + kXyzFromRgb[r][1] * rgb[i + 1] + kXyzFromRgb[r][2] * rgb[i + 2];
    }
  }
  return xyz;
}

double two_sided_p(double z) { return std::erfc(std::abs(z) / std::sqrt(2.0)); }

/// The level of one of `count` tests that together have level `alpha` [Sidak 1967].
double sidak(double alpha, double count) { return -std::expm1(std::log1p(-alpha) / count); }

ZCheck check_values(const std::vector<double>& z, double level, double fraction) {
  ZCheck check;
  std::size_t accepted = 0;
  for (const double value : z) {
    accepted += two_sided_p(value) > level;
    check.max_z = std::max(check.max_z, std::abs(value));
  }
  check.accepted = static_cast<double>(accepted) / static_cast<double>(z.size());
  check.pass = check.accepted >= fraction;
  return check;
}

/// Differences, references and variances summed over blocks of `block` pixels a side.
ZCheck check_sums(const ZImage& size, const std::vector<double>& difference,
                  const std::vector<double>& reference, const std::vector<double>& variance,
                  std::size_t block, const ZOptions& options) {
  std::vector<double> z;
  for (std::size_t y0 = 0; y0 < size.height; y0 += block) {
    for (std::size_t x0 = 0; x0 < size.width; x0 += block) {
      for (std::size_t c = 0; c < 3; ++c) {
        double d = 0, r = 0, v = 0;
        for (std::size_t y = y0; y < std::min(y0 + block, size.height); ++y) {
          for (std::size_t x = x0; x < std::min(x0 + block, size.width); ++x) {
            const std::size_t i = 3 * (y * size.width + x) + c;
            d += difference[i];
            r += reference[i];
            v += variance[i];
          }
        }
        z.push_back(std::max(std::abs(d) - options.tolerance * std::abs(r), 0.0) / std::sqrt(v));
      }
    }
  }
  return check_values(z, sidak(options.alpha_of_sums, static_cast<double>(z.size())), options.fraction);
}

}  // namespace

std::string ZResult::report() const {
  char text[512];
  const auto verdict = [](const ZCheck& check) { return check.pass ? "pass" : "FAIL"; };
  std::snprintf(text, sizeof(text),
                "mean bias %% R %+.3f G %+.3f B %+.3f, non-finite pixels %zu\n"
                "suite   %s  accepted %.3f %%, max z %.2f\nown     %s  accepted %.3f %%, max z %.2f\n"
                "block   %s  accepted %.3f %%, max z %.2f\nglobal  %s  accepted %.3f %%, max z %.2f",
                bias_percent[0], bias_percent[1], bias_percent[2], bad_pixels, verdict(suite),
                100 * suite.accepted, suite.max_z, verdict(own), 100 * own.accepted, own.max_z,
                verdict(block), 100 * block.accepted, block.max_z, verdict(global), 100 * global.accepted,
                global.max_z);
  return text;
}

ZResult z_test(const ZImage& reference, const ZImage& reference_variance, const ZImage& tested,
               const ZImage& variance, const ZOptions& options) {
  ZResult result;
  const std::size_t pixels = reference.width * reference.height, values = 3 * pixels;
  std::vector<double> test = tested.rgb;
  for (std::size_t p = 0; p < pixels; ++p) {
    bool bad = false;
    for (std::size_t i = 3 * p; i < 3 * p + 3; ++i) {
      if (std::isfinite(test[i])) continue;
      test[i] = 1e30;
      bad = true;
    }
    result.bad_pixels += bad;
  }
  const double level = sidak(options.alpha, static_cast<double>(pixels));

  const std::vector<double> test_xyz = xyz_of(test), reference_xyz = xyz_of(reference.rgb),
                            variance_xyz = xyz_of(reference_variance.rgb);
  std::vector<double> z(values);
  for (std::size_t i = 0; i < values; ++i) {
    const double error = std::sqrt(std::max(variance_xyz[i], kLeastVariance) / options.spp);
    z[i] = std::abs(test_xyz[i] - reference_xyz[i]) / error;
  }
  result.suite = check_values(z, level, options.fraction);

  std::vector<double> difference(values), of_means(values);
  for (std::size_t i = 0; i < values; ++i) {
    const double own = std::max(variance.rgb[i], 0.0) / options.spp;
    const double theirs = std::abs(reference_variance.rgb[i]) / options.reference_spp;
    difference[i] = test[i] - reference.rgb[i];
    z[i] = std::abs(difference[i]) / std::sqrt(std::max(own, kLeastVariance / options.spp) + theirs);
    const double rounding = 1e-6 * (1 + std::abs(reference.rgb[i]));
    of_means[i] = own + theirs + rounding * rounding;
  }
  result.own = check_values(z, level, options.fraction);
  result.block = check_sums(reference, difference, reference.rgb, of_means, options.block, options);
  result.global = check_sums(reference, difference, reference.rgb, of_means,
                             std::max(reference.width, reference.height), options);

  for (std::size_t c = 0; c < 3; ++c) {
    double sum = 0, reference_sum = 0;
    for (std::size_t i = c; i < values; i += 3) {
      sum += difference[i];
      reference_sum += reference.rgb[i];
    }
    result.bias_percent[c] =
        100 * sum / std::max(std::abs(reference_sum), 1e-12 * static_cast<double>(pixels));
  }
  return result;
}

}  // namespace tessera::test
