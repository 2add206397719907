#include "image/metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "wire/colour_channels.h"

namespace tessera::client {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The continued fraction of the incomplete beta function [DLMF 8.17.22], by Lentz's method [Lentz 1976].
double beta_fraction(double a, double b, double x) {
  constexpr double kTiny = 1e-300;
  constexpr int kMaxTerms = 400;
  const auto away_from_zero = [](double v) { return std::abs(v) > kTiny ? v : kTiny; };
  double c = 1, d = 1 / away_from_zero(1 - (a + b) * x / (a + 1));
  double value = d;
  const auto append = [&](double term) {
    d = 1 / away_from_zero(1 + term * d);
    c = away_from_zero(1 + term / c);
    value *= d * c;
  };
  for (int m = 1; m < kMaxTerms; ++m) {
    append(m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)));
    append(-(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1)));
    if (std::abs(d * c - 1) < 1e-14) break;
  }
  return value;
}

// The regularised incomplete beta function I_x(a, b).
double incomplete_beta(double a, double b, double x) {
  if (x <= 0) return 0;
  if (x >= 1) return 1;
  const double front =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x));
  // The fraction converges fast on the near side of the mean only.
  if (x < (a + 1) / (a + b + 2)) return front * beta_fraction(a, b, x) / a;
  return 1 - front * beta_fraction(b, a, 1 - x) / b;
}

struct MeanVariance {
  double mean = 0;
  double variance = 0;  // unbiased; NaN for one value
};

MeanVariance mean_variance(const std::vector<double>& values) {
  const double n = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double squares = 0;
  for (double v : values) squares += (v - mean) * (v - mean);
  return {mean, values.size() > 1 ? squares / (n - 1) : std::numeric_limits<double>::quiet_NaN()};
}

// Pixels of `n` that are left without the worst share, at least one.
std::size_t kept_of(std::size_t n, double trim_percent) {
  const auto all = static_cast<double>(n);
  return static_cast<std::size_t>(std::max(1.0, all - std::ceil(all * trim_percent / 100)));
}

// The mean, and the mean without the worst share. Sorts.
std::pair<double, double> means(std::vector<double>& errors, double trim_percent) {
  std::ranges::sort(errors);
  const double n = static_cast<double>(errors.size());
  const std::size_t kept = kept_of(errors.size(), trim_percent);
  const double rest = std::accumulate(errors.begin(), errors.begin() + std::ptrdiff_t(kept), 0.0);
  const double all = std::accumulate(errors.begin() + std::ptrdiff_t(kept), errors.end(), rest);
  return {all / n, rest / static_cast<double>(kept)};
}

// Red, green and blue of both images in double, zero where either is not finite.
struct Pair {
  std::array<std::vector<double>, 3> reference, test;
  std::vector<bool> finite;

  Pair(const Image& reference_image, const Image& test_image) : finite(reference_image.pixel_count(), true) {
    const RgbPlanes r = rgb_planes(reference_image), t = rgb_planes(test_image);
    const std::array<const float*, 3> reference_planes{r.r, r.g, r.b}, test_planes{t.r, t.g, t.b};
    for (std::size_t i = 0; i < finite.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        if (!std::isfinite(reference_planes[c][i]) || !std::isfinite(test_planes[c][i])) finite[i] = false;
      }
    }
    for (int c = 0; c < 3; ++c) {
      reference[c].resize(finite.size());
      test[c].resize(finite.size());
      for (std::size_t i = 0; i < finite.size(); ++i) {
        if (!finite[i]) continue;
        reference[c][i] = reference_planes[c][i];
        test[c][i] = test_planes[c][i];
      }
    }
  }
};

/// Sums over the rectangles from the upper left corner; a row and a column of zeros come first.
std::vector<double> sums_of(const std::vector<double>& values, std::size_t width) {
  const std::size_t height = values.size() / width, stride = width + 1;
  std::vector<double> sums(stride * (height + 1));
  for (std::size_t y = 0; y < height; ++y) {
    double row = 0;
    for (std::size_t x = 0; x < width; ++x) {
      row += values[y * width + x];
      sums[(y + 1) * stride + x + 1] = sums[y * stride + x + 1] + row;
    }
  }
  return sums;
}

void measure_errors(const Pair& pair, const CompareOptions& options, Comparison& out) {
  std::vector<double> squared, relative;
  for (std::size_t i = 0; i < pair.finite.size(); ++i) {
    if (!pair.finite[i]) continue;
    double sum = 0, relative_sum = 0;
    for (int c = 0; c < 3; ++c) {
      const double reference = pair.reference[c][i];
      const double d2 = (pair.test[c][i] - reference) * (pair.test[c][i] - reference);
      sum += d2;
      relative_sum += d2 / (reference * reference + options.epsilon);
    }
    squared.push_back(sum / 3);
    relative.push_back(relative_sum / 3);
  }
  std::tie(out.mse, out.mse_trimmed) = means(squared, options.trim_percent);
  const std::vector<double> in_order = relative;
  std::tie(out.relmse, out.relmse_trimmed) = means(relative, options.trim_percent);
  const double worst = relative[kept_of(relative.size(), options.trim_percent) - 1];
  std::array<std::vector<double>, 3> difference = pair.test;
  for (std::size_t i = 0, finite = 0; i < pair.finite.size(); ++i) {
    const bool counts = pair.finite[i] && in_order[finite++] <= worst;
    for (std::size_t c = 0; c < 3; ++c)
      difference[c][i] = counts ? pair.test[c][i] - pair.reference[c][i] : 0;
  }
  out.block = options.block;
  out.relmse_block = relmse_of_blocks(pair.reference, difference, out.width, options.block, options.epsilon);
}

// Differences of channel `c` in the block whose upper left pixel is (x, y).
std::vector<double> block_differences(const Pair& pair, int c, int x, int y, int block, int width) {
  std::vector<double> differences;
  differences.reserve(std::size_t(block) * std::size_t(block));
  for (int row = y; row < y + block; ++row) {
    for (int column = x; column < x + block; ++column) {
      const std::size_t i = std::size_t(row) * std::size_t(width) + std::size_t(column);
      differences.push_back(pair.test[c][i] - pair.reference[c][i]);
    }
  }
  return differences;
}

void test_blocks(const Pair& pair, int block, Comparison& out) {
  const int columns = out.width / block, rows = out.height / block;
  out.blocks = std::uint64_t(columns) * std::uint64_t(rows);
  out.block_tests = 3 * out.blocks;
  const double level = -std::expm1(std::log1p(-0.01) / static_cast<double>(out.block_tests));  // [Sidak 1967]
  for (int c = 0; c < 3; ++c) {
    std::vector<double> block_means;
    for (int y = 0; y < rows * block; y += block) {
      for (int x = 0; x < columns * block; x += block) {
        const MeanVariance in_block = mean_variance(block_differences(pair, c, x, y, block, out.width));
        block_means.push_back(in_block.mean);
        const double error = std::sqrt(in_block.variance) / block;
        const double t = error > 0 ? std::abs(in_block.mean) / error : in_block.mean == 0 ? 0 : kInfinity;
        if (student_t_p_value(t, block * block - 1) <= level) ++out.blocks_rejected;
      }
    }
    const MeanVariance over_blocks = mean_variance(block_means);
    const double error = std::sqrt(over_blocks.variance / static_cast<double>(out.blocks));
    ChannelBias& bias = out.channels[c];
    bias.mean_reference = mean_variance(pair.reference[c]).mean;
    bias.mean_test = mean_variance(pair.test[c]).mean;
    bias.bias = over_blocks.mean;
    bias.bias_percent = 100 * bias.bias / std::max(std::abs(bias.mean_reference), 1e-12);
    // With one block there is no spread to judge by: any difference counts.
    bias.t = error > 0 ? bias.bias / error : bias.bias == 0 ? 0 : kInfinity;
    bias.p = student_t_p_value(bias.t, static_cast<double>(out.blocks) - 1);
  }
}

constexpr auto kNames = wire::kColourChannels;

}  // namespace

double student_t_p_value(double t, double dof) {
  if (t == 0) return 1;
  return std::isfinite(t) ? incomplete_beta(dof / 2, 0.5, dof / (dof + t * t)) : 0;
}

double student_t_quantile(double p, double dof) {
  double low = 0, high = 1;
  while (student_t_p_value(high, dof) > p && high < 1e12) high *= 2;
  for (int i = 0; i < 100; ++i) {
    const double middle = (low + high) / 2;
    (student_t_p_value(middle, dof) > p ? low : high) = middle;
  }
  return high;
}

double relmse_of_blocks(const std::array<std::vector<double>, 3>& reference,
                        const std::array<std::vector<double>, 3>& difference, int width, int block,
                        double epsilon) {
  const auto columns = static_cast<std::size_t>(width), side = static_cast<std::size_t>(block);
  const std::size_t rows = reference[0].size() / columns, stride = columns + 1;
  const auto pixels = static_cast<double>(side * side);
  double sum = 0, terms = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::vector<double> references = sums_of(reference[c], columns),
                              differences = sums_of(difference[c], columns);
    for (std::size_t y = 0; y + side <= rows; ++y) {
      for (std::size_t x = 0; x + side <= columns; ++x) {
        const auto mean_of = [&](const std::vector<double>& sums) {
          const double *const upper = &sums[y * stride + x], *const lower = upper + side * stride;
          return (lower[side] - lower[0] - upper[side] + upper[0]) / pixels;
        };
        const double mean = mean_of(references), off = mean_of(differences);
        sum += off * off / (mean * mean + epsilon);
        ++terms;
      }
    }
  }
  return sum / terms * pixels;
}

absl::StatusOr<Comparison> compare_images(const Image& reference, const Image& test,
                                          const CompareOptions& options) {
  const auto size = [](const Image& image) {
    return absl::StrCat(image.data.width(), "x", image.data.height());
  };
  if (reference.channels.empty() || test.channels.empty())
    return absl::InvalidArgumentError("an image has no channels");
  if (reference.data.width() != test.data.width() || reference.data.height() != test.data.height()) {
    return absl::InvalidArgumentError(
        absl::StrCat("image sizes differ: ", size(reference), " and ", size(test)));
  }
  for (const int block : {options.test_block, options.block}) {
    if (std::min(reference.data.width(), reference.data.height()) >= block) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("images of ", size(reference), " are smaller than one block of ", block, "x", block));
  }
  const Pair pair(reference, test);
  Comparison out;
  out.width = reference.data.width();
  out.height = reference.data.height();
  out.non_finite_pixels = static_cast<std::uint64_t>(std::ranges::count(pair.finite, false));
  if (out.non_finite_pixels == pair.finite.size())
    return absl::InvalidArgumentError("no pixel is finite in both images");
  measure_errors(pair, options, out);
  test_blocks(pair, options.test_block, out);
  return out;
}

std::string to_text(const Comparison& c, const CompareOptions& options) {
  std::string text = absl::StrFormat(
      "%dx%d  non-finite pixels %d\n"
      "MSE    %.6g  (without worst %g %%: %.6g)\n"
      "relMSE %.6g  (without worst %g %%: %.6g)  epsilon %g\n"
      "relMSE of means over %dx%d pixels, times %d, without worst %g %%: %.6g\n",
      c.width, c.height, c.non_finite_pixels, c.mse, options.trim_percent, c.mse_trimmed, c.relmse,
      options.trim_percent, c.relmse_trimmed, options.epsilon, c.block, c.block, c.block * c.block,
      options.trim_percent, c.relmse_block);
  for (int i = 0; i < 3; ++i) {
    const ChannelBias& b = c.channels[i];
    absl::StrAppendFormat(&text, "%s  reference mean %.6g  test mean %.6g  bias %+.4f %%  t %+.2f  p %.3g\n",
                          kNames[i], b.mean_reference, b.mean_test, b.bias_percent, b.t, b.p);
  }
  absl::StrAppendFormat(&text, "blocks %dx%d: %d; block-channel tests rejected %d of %d", options.test_block,
                        options.test_block, c.blocks, c.blocks_rejected, c.block_tests);
  return text;
}

std::string to_json(const Comparison& c) {
  nlohmann::ordered_json json{{"size", {c.width, c.height}},
                              {"non_finite_pixels", c.non_finite_pixels},
                              {"mse", c.mse},
                              {"relmse", c.relmse},
                              {"mse_trimmed", c.mse_trimmed},
                              {"relmse_trimmed", c.relmse_trimmed},
                              {"block", c.block},
                              {"relmse_block", c.relmse_block},
                              {"blocks", c.blocks}};
  for (int i = 0; i < 3; ++i) {
    const ChannelBias& b = c.channels[i];
    json["channels"][kNames[i]] = {{"mean_ref", b.mean_reference},
                                   {"mean_test", b.mean_test},
                                   {"bias", b.bias},
                                   {"bias_percent", b.bias_percent},
                                   {"t", b.t},
                                   {"p", b.p}};
  }
  json["blocks_rejected"] = c.blocks_rejected;
  json["block_tests"] = c.block_tests;
  return json.dump(1);
}

}  // namespace tessera::client
