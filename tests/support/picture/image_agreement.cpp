#include "support/picture/image_agreement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "support/picture/p_values.h"

namespace tessera::test {
namespace {

using Triple = std::array<double, 3>;

// The matrix of Mitsuba's suite.
constexpr double kXyzFromRgb[3][3] = {
    {0.412453, 0.357580, 0.180423}, {0.212671, 0.715160, 0.072169}, {0.019334, 0.119193, 0.950227}};
// Mitsuba's rule for pixels: variances below are not believed (fireflies that no sample has met), levels are
// of the whole image, and so many pixels may be beyond theirs.
constexpr double kLeastVariance = 1e-4;
constexpr double kPixelLevel = 0.01;
constexpr double kPixelsBeyond = 0.0025;
// Probability that the reference's own noise is anywhere larger than taken into account.
constexpr double kReferenceLevel = 1e-3;
// Single precision, twice: 1.2 10^-7 of the value and as much for sums of samples.
constexpr double kRounding = 1e-6;
constexpr std::size_t kBlock = 8;

/// Sums over some pixels, in XYZ.
struct Cell {
  Triple difference{}, reference{}, variance{}, reference_variance{};
  double pixels = 0;

  void add(const Cell& other) {
    for (std::size_t c = 0; c < 3; ++c) {
      difference[c] += other.difference[c];
      reference[c] += other.reference[c];
      variance[c] += other.variance[c];
      reference_variance[c] += other.reference_variance[c];
    }
    pixels += other.pixels;
  }
};

Triple xyz_of(const double* rgb) {
  Triple xyz{};
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) xyz[r] += kXyzFromRgb[r][c] * rgb[c];
  }
  return xyz;
}

/// Variance of one sample in XYZ, at most: where noise of all colours goes together, as of grey light.
Triple most_variance_in_xyz(const double* rgb) {
  const double deviation[3] = {std::sqrt(std::max(rgb[0], 0.0)), std::sqrt(std::max(rgb[1], 0.0)),
                               std::sqrt(std::max(rgb[2], 0.0))};
  Triple xyz = xyz_of(deviation);
  for (double& value : xyz) value *= value;
  return xyz;
}

std::vector<Cell> cells_of_pixels(const ReferenceImage& reference, const RgbPlanes& image,
                                  const RgbPlanes& variance) {
  std::vector<Cell> cells(reference.mean.width * reference.mean.height);
  for (std::size_t p = 0; p < cells.size(); ++p) {
    Cell& cell = cells[p];
    cell.pixels = 1;
    cell.reference = xyz_of(&reference.mean.rgb[3 * p]);
    cell.difference = xyz_of(&image.rgb[3 * p]);
    cell.reference_variance = xyz_of(&reference.variance.rgb[3 * p]);
    const Triple own = most_variance_in_xyz(&variance.rgb[3 * p]);
    for (std::size_t c = 0; c < 3; ++c) {
      cell.difference[c] -= cell.reference[c];
      cell.reference_variance[c] = std::max(cell.reference_variance[c], 0.0);
      // Some thousand samples may all have missed a rare light; the reference has ten times as many.
      cell.variance[c] = std::max(own[c], cell.reference_variance[c]);
    }
  }
  return cells;
}

/// The least p-value of each cell's three, times three.
std::vector<double> p_values_of(const std::vector<Cell>& cells, double least_variance, double reference_spp,
                                const AgreementOptions& options) {
  const double standard_errors =
      normal_quantile(0.5 * sidak_level(kReferenceLevel, static_cast<int>(3 * cells.size())));
  std::vector<double> p_values;
  for (const Cell& cell : cells) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < 3; ++c) {
      const double allowed = options.tolerance * std::abs(cell.reference[c]) +
                             standard_errors * std::sqrt(cell.reference_variance[c] / reference_spp) +
                             kRounding * (cell.pixels + std::abs(cell.reference[c]));
      const double variance = std::max(cell.variance[c], least_variance) / options.spp;
      const double p = interval_p_value(cell.difference[c], allowed, std::sqrt(variance));
      least = std::min(least, std::isfinite(p) ? p : 0);  // a value that is not a number is wrong
    }
    p_values.push_back(std::min(3 * least, 1.0));
  }
  return p_values;
}

double bonferroni(const std::vector<double>& p_values) {
  const double least = *std::min_element(p_values.begin(), p_values.end());
  return std::min(least * static_cast<double>(p_values.size()), 1.0);
}

}  // namespace

double ImageAgreement::p_value() const { return std::min(3 * std::min({pixels, blocks, whole}), 1.0); }

ImageAgreement agreement(const ReferenceImage& reference, const RgbPlanes& image, const RgbPlanes& variance,
                         const AgreementOptions& options) {
  const std::vector<Cell> pixels = cells_of_pixels(reference, image, variance);
  const std::size_t width = reference.mean.width, columns = (width + kBlock - 1) / kBlock;
  std::vector<Cell> blocks(columns * ((reference.mean.height + kBlock - 1) / kBlock)), whole(1);
  for (std::size_t p = 0; p < pixels.size(); ++p) {
    blocks[p / width / kBlock * columns + p % width / kBlock].add(pixels[p]);
    whole[0].add(pixels[p]);
  }

  ImageAgreement result;
  const double level = sidak_level(kPixelLevel, static_cast<int>(pixels.size()));
  const std::vector<double> of_pixels = p_values_of(pixels, kLeastVariance, reference.spp, options);
  const auto beyond = std::count_if(of_pixels.begin(), of_pixels.end(), [&](double p) { return p <= level; });
  result.pixels = binomial_tail(static_cast<std::size_t>(beyond), pixels.size(), kPixelsBeyond);
  result.blocks = bonferroni(p_values_of(blocks, 0, reference.spp, options));
  result.whole = bonferroni(p_values_of(whole, 0, reference.spp, options));

  for (std::size_t c = 0; c < 3; ++c) {
    double sum = 0, reference_sum = 0;
    for (std::size_t i = c; i < image.rgb.size(); i += 3) {
      sum += image.rgb[i] - reference.mean.rgb[i];
      reference_sum += reference.mean.rgb[i];
    }
    result.bias_percent[c] = 100 * sum / std::abs(reference_sum);
  }
  return result;
}

}  // namespace tessera::test
