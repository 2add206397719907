#include "bench/bias.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "image/metrics.h"
#include "wire/colour_channels.h"

namespace tessera::client {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr auto kChannels = wire::kColourChannels;
constexpr double kEpsilon = CompareOptions{}.epsilon;

double square(double x) { return x * x; }

}  // namespace

/// Sums over pixels near each other, which may share noise.
class BiasEstimator::Block {
 public:
  explicit Block(std::size_t groups) : products_(groups * groups), off_(groups) {}

  std::size_t terms = 0;
  double image_variance = 0;
  // Variance of bias2_sum() if pixels shared no noise, and that which the reference brings.
  double pixel_error2 = 0;

  std::vector<double>& off() { return off_; }
  /// Adds the products of what the groups are off at a pixel.
  void add(double weight) {
    for (std::size_t i = 0; i < off_.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) products_[i * off_.size() + j] += weight * off_[i] * off_[j];
    }
  }
  double bias2_sum() const { return sums().all / pairs(); }

  /// Variance of that mean over pairs: E m^2 - (E m)^2, the latter from pairs that have no image in common
  /// [Hoeffding 1948]. NaN for fewer than four groups.
  double error2() const {
    const auto n = static_cast<double>(off_.size());
    if (n < 4) return kUnknown;
    const Sums s = sums();
    const double apart = (s.all * s.all + s.squares - s.rows2) / (pairs() * (n - 2) * (n - 3) / 2);
    return square(s.all / pairs()) - apart;
  }

 private:
  /// Over pairs: their sum, that of their squares, and the squares of the sums of those with one image.
  struct Sums {
    double all = 0, squares = 0, rows2 = 0;
  };
  double pairs() const { return static_cast<double>(off_.size() * (off_.size() - 1)) / 2; }
  Sums sums() const {
    const std::size_t n = off_.size();
    Sums sums;
    for (std::size_t i = 0; i < n; ++i) {
      double row = 0;
      for (std::size_t j = 0; j < n; ++j) {
        if (i == j) continue;
        const double product = products_[std::max(i, j) * n + std::min(i, j)];
        row += product;
        sums.squares += square(product) / 2;  // each pair is met twice
      }
      sums.all += row / 2;
      sums.rows2 += square(row);
    }
    return sums;
  }

  std::vector<double> products_;  // entries of groups i > j alone are set
  std::vector<double> off_;
};

BiasEstimator::BiasEstimator(const Image& reference, double reference_noise, std::uint32_t images)
    : reference_(reference),
      reference_noise_(reference_noise),
      images_(images),
      groups_(std::min(images, kMostGroups)),
      mean_(kChannels.size() * reference.pixel_count()),
      squares_(mean_.size()) {
  for (Group& group : groups_) group.mean.resize(mean_.size());
}

void BiasEstimator::add(const Image& image) {
  Group& group = groups_[std::uint64_t{count_} * groups_.size() / images_];
  ++group.count, ++count_;
  std::size_t at = 0;
  for (const char* name : kChannels) {
    for (const float value : image.find(name)->values) {
      group.mean[at] += (value - group.mean[at]) / static_cast<float>(group.count);
      // Running means [Welford 1962].
      const double off = value - mean_[at];
      mean_[at] += off / count_;
      squares_[at] += off * (value - mean_[at]);
      ++at;
    }
  }
}

Image BiasEstimator::mean() const {
  Image image;
  image.data = reference_.data;
  image.display = reference_.display;
  auto value = mean_.begin();
  for (const char* name : kChannels) {
    std::vector<float>& values = image.add(name).values;
    for (float& to : values) to = static_cast<float>(*value++);
  }
  return image;
}

void BiasEstimator::read(std::size_t value, float reference, Block& block) const {
  const double weight = 1 / (square(reference) + kEpsilon);
  const double variance = weight * squares_[value] / (count_ - 1), off = mean_[value] - reference;
  if (!std::isfinite(variance) || !std::isfinite(off)) return;
  for (std::size_t g = 0; g < groups_.size(); ++g) block.off()[g] = groups_[g].mean[value] - reference;
  block.add(weight);
  block.image_variance += variance;
  ++block.terms;
  // Noise of the reference is the same in all pairs; channels may share all of it.
  const auto k = static_cast<double>(count_);
  block.pixel_error2 +=
      2 * square(variance) / (k * (k - 1)) + static_cast<double>(kChannels.size()) * reference_noise_ *
                                                 (4 * weight * square(off) + 2 * reference_noise_);
}

BiasAndVariance BiasEstimator::result() const {
  if (count_ < 2) return {kUnknown, kUnknown, kUnknown};
  const auto width = static_cast<std::size_t>(reference_.data.width());
  const auto side = static_cast<std::size_t>(CompareOptions{}.test_block);
  std::map<std::pair<std::size_t, std::size_t>, Block> blocks;
  for (std::size_t c = 0; c < kChannels.size(); ++c) {
    const std::vector<float>& reference = reference_.find(kChannels[c])->values;
    for (std::size_t i = 0; i < reference.size(); ++i) {
      Block& block = blocks.try_emplace({i % width / side, i / width / side}, groups_.size()).first->second;
      read(c * reference.size() + i, reference[i], block);
    }
  }
  double terms = 0, bias2 = 0, variance = 0, error2 = 0, pixel_error2 = 0;
  for (const auto& [place, block] : blocks) {
    terms += static_cast<double>(block.terms);
    bias2 += block.bias2_sum();
    variance += block.image_variance;
    error2 += block.error2();
    pixel_error2 += block.pixel_error2;
  }
  // NaN stays.
  const double error = std::sqrt(error2 < pixel_error2 ? pixel_error2 : error2);
  return {bias2 / terms - reference_noise_, error / terms, variance / terms};
}

}  // namespace tessera::client
