// The estimator of bias and variance on images whose bias and variance are known.
#include "bench/bias.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tessera::client {
namespace {

constexpr int kSide = 64, kSeeds = 4;
constexpr double kEpsilon = 0.01;  // relMSE's

Image empty_image() {
  Image image;
  image.data = image.display = {0, 0, kSide, kSide};
  return image;
}

/// One experiment: a picture of the value 1, images of it with `bias` in one half and noise of this standard
/// deviation, and a reference with noise of its own.
BiasAndVariance measure(double bias, double noise, double reference_noise, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const auto image_of = [&](double offset, double deviation) {
    Image image = empty_image();
    for (const char* name : {"R", "G", "B"}) {
      std::vector<float>& values = image.add(name).values;
      for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = static_cast<float>(1 + (i % 2 == 0 ? offset : 0) + deviation * normal(random));
    }
    return image;
  };
  const Image reference = image_of(0, reference_noise);
  BiasEstimator estimator(reference, reference_noise * reference_noise / (1 + kEpsilon), kSeeds);
  for (int seed = 0; seed < kSeeds; ++seed) estimator.add(image_of(bias, noise));
  return estimator.result();
}

/// Mean and standard error over repeated experiments.
struct Mean {
  double value = 0, error = 0;
};
template <class F>
Mean mean_of(F value, int times = 100) {
  double sum = 0, squares = 0;
  for (int i = 0; i < times; ++i) {
    const double one = value();
    sum += one, squares += one * one;
  }
  const double mean = sum / times;
  return {mean, std::sqrt((squares / times - mean * mean) / (times - 1))};
}

TEST(BiasEstimator, IsUnbiasedItself) {
  // The weight 1 / (R^2 + 0.01) of a reference with noise of 0.02 is off by some 3 * 0.02^2: 0.12 %. Half of
  // the pixels have the bias: its mean square is bias^2 / 2.
  for (const double bias : {0.0, 0.05, 0.3}) {
    SCOPED_TRACE(bias);
    std::mt19937_64 random(7);
    const Mean estimate = mean_of([&] { return measure(bias, 0.2, 0.02, random).bias2; });
    const double truth = bias * bias / 2 / (1 + kEpsilon);
    EXPECT_NEAR(estimate.value, truth, 5 * estimate.error + 0.005 * truth + 3e-6);
    // The test sees what would be left without the corrections: V / K = 0.01 and V_R = 4e-4.
    EXPECT_LT(5 * estimate.error, 3e-4);
  }
}

TEST(BiasEstimator, KnowsTheVarianceOfOneImage) {
  std::mt19937_64 random(8);
  const Mean estimate = mean_of([&] { return measure(0.1, 0.2, 0, random).variance; });
  EXPECT_NEAR(estimate.value, 0.04 / (1 + kEpsilon), 5 * estimate.error);
  EXPECT_LT(estimate.error, 1e-4);
}

TEST(BiasEstimator, TellsBiasFromNoise) {
  std::mt19937_64 random(9);
  int false_alarms = 0, found = 0;
  for (int i = 0; i < 200; ++i) {
    false_alarms += measure(0, 0.2, 0.02, random).is_biased();
    found += measure(0.05, 0.2, 0.02, random).is_biased();
  }
  // Three standard errors that are themselves off by a quarter (16 blocks): at most as Student's t with 8
  // degrees of freedom, 1.7 in 200; eight or fewer in all but one of 4000 such tests.
  EXPECT_LE(false_alarms, 8);
  EXPECT_EQ(found, 200) << "a bias of a quarter of the noise";
}

TEST(BiasEstimator, TheStandardErrorIsThatOfTheEstimate) {
  std::mt19937_64 random(10), again(10);
  for (const double bias : {0.0, 0.3}) {
    const Mean spread = mean_of([&] { return measure(bias, 0.2, 0, random).bias2; });
    const Mean claimed = mean_of([&] { return measure(bias, 0.2, 0, again).bias2_error; });
    // A standard deviation of 100 values is off by 7 %: three of these, and what is claimed is no less than
    // for pixels without common noise, which makes it up to a fifth too large.
    EXPECT_GT(claimed.value, 0.8 * spread.error * std::sqrt(100.0)) << bias;
    EXPECT_LT(claimed.value, 1.45 * spread.error * std::sqrt(100.0)) << bias;
  }
}

TEST(BiasEstimator, NoiseThatPixelsShareIsNoBias) {
  // One number for each block of 16x16 pixels, as algorithms have it that share records among pixels.
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  Image reference = empty_image();
  for (const char* name : {"R", "G", "B"}) reference.add(name).values.assign(kSide * kSide, 1);
  int false_alarms = 0;
  for (int i = 0; i < 100; ++i) {
    BiasEstimator estimator(reference, 0, kSeeds);
    for (int seed = 0; seed < kSeeds; ++seed) {
      Image image = reference;
      double of_block[16];
      for (double& value : of_block) value = 1 + 0.2 * normal(random);
      for (Channel& channel : image.channels) {
        for (int p = 0; p < kSide * kSide; ++p)
          channel.values[static_cast<std::size_t>(p)] =
              static_cast<float>(of_block[p / kSide / 16 * 4 + p % kSide / 16]);
      }
      estimator.add(image);
    }
    false_alarms += estimator.result().is_biased();
  }
  // The same as above; with errors of single pixels, half of the estimates (those above 0) would be alarms.
  EXPECT_LE(false_alarms, 10);
}

TEST(BiasEstimator, BiasInOneCornerIsSeen) {
  // It makes the blocks unlike each other, which is no noise.
  std::mt19937_64 random(12);
  std::normal_distribution<double> normal;
  Image reference = empty_image();
  for (const char* name : {"R", "G", "B"}) reference.add(name).values.assign(kSide * kSide, 1);
  BiasEstimator estimator(reference, 0, kSeeds);
  for (int seed = 0; seed < kSeeds; ++seed) {
    Image image = reference;
    for (Channel& channel : image.channels) {
      for (int p = 0; p < kSide * kSide; ++p)
        channel.values[static_cast<std::size_t>(p)] +=
            static_cast<float>((p / kSide < 16 && p % kSide < 16 ? 0.5 : 0) + 0.05 * normal(random));
    }
    estimator.add(image);
  }
  EXPECT_TRUE(estimator.result().is_biased());
  EXPECT_NEAR(estimator.result().bias2, 0.25 / 16 / (1 + kEpsilon), 3 * estimator.result().bias2_error);
}

TEST(BiasEstimator, ManyImagesAreKeptAsMeans) {
  Image reference = empty_image(), image = empty_image();
  for (const char* name : {"R", "G", "B"}) {
    reference.add(name).values.assign(kSide * kSide, 1);
    image.add(name).values.assign(kSide * kSide, 1.5f);
  }
  BiasEstimator estimator(reference, 0, 100);
  for (int i = 0; i < 100; ++i) estimator.add(image);
  EXPECT_NEAR(estimator.result().bias2, 0.25 / (1 + kEpsilon), 1e-6);
  EXPECT_NEAR(estimator.result().variance, 0, 1e-12);
}

TEST(BiasEstimator, LeavesOutWhatIsNotFinite) {
  Image reference = empty_image(), image = empty_image();
  for (const char* name : {"R", "G", "B"}) {
    for (float& value : reference.add(name).values) value = 1;
    for (float& value : image.add(name).values) value = 1;
  }
  image.channels[0].values[5] = INFINITY;
  BiasEstimator estimator(reference, 0, 2);
  EXPECT_TRUE(std::isnan(estimator.result().bias2));
  for (int i = 0; i < 2; ++i) estimator.add(image);
  EXPECT_EQ(estimator.result().bias2, 0);
  EXPECT_EQ(estimator.result().variance, 0);
  EXPECT_EQ(estimator.mean().find("G")->values[5], 1);
}

}  // namespace
}  // namespace tessera::client
