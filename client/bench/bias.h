// Bias apart from variance, from images of several seeds.
#pragma once

#include <cstdint>
#include <vector>

#include "image/image.h"

namespace tessera::client {

/// Means over pixels and channels, each relative to the reference as in relMSE (metrics.h): the squares of a
/// pixel are divided by R^2 + 0.01.
struct BiasAndVariance {
  double bias2 = 0;        // square of the bias, estimated without bias: may be negative where there is none
  double bias2_error = 0;  // its standard error; NaN for fewer than four images
  double variance = 0;     // variance of one image

  /// Whether the bias stands out from the noise.
  bool is_biased() const { return bias2 > 3 * bias2_error; }
};

/// Compares images of independent seeds with a reference. The product of what two images X and Y deviate from
/// the reference R has the mean
///
///     E (X - R)(Y - R) = bias^2 + V_R
///
/// without the variance of either, for both are independent; V_R is the variance of the reference itself.
/// Over all pairs of K images that is (M - R)^2 - V / K, with their mean M and the variance V of one image.
class BiasEstimator {
 public:
  /// `reference_noise`: V_R over R^2 + 0.01, mean over pixels and channels; 0 where it is not known, which
  /// then counts as bias. `images`: how many there will be. The reference must outlive this.
  BiasEstimator(const Image& reference, double reference_noise, std::uint32_t images);

  /// An image of the reference's size.
  void add(const Image& image);

  /// The mean of all images; R, G and B alone.
  Image mean() const;

  /// NaN for fewer than two images. Pixels that are not finite in some image are left out.
  BiasAndVariance result() const;

 private:
  /// Means of images are images, too: of many, so many means are kept.
  static constexpr std::uint32_t kMostGroups = 16;
  struct Group {
    std::vector<float> mean;
    std::uint32_t count = 0;
  };
  class Block;

  /// Adds the value of a channel's pixel to its block, unless some image is not finite there.
  void read(std::size_t value, float reference, Block& block) const;

  const Image& reference_;
  const double reference_noise_;
  const std::uint32_t images_;
  std::uint32_t count_ = 0;
  std::vector<Group> groups_;
  std::vector<double> mean_, squares_;  // a channel after the other; squares of what deviates from the mean
};

}  // namespace tessera::client
