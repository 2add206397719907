#include "support/picture/image_agreement.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <random>

#include "support/picture/p_values.h"

namespace tessera::test {
namespace {

TEST(PValues, OfAnIntervalAreOneOrTwoSidedAtItsEnds) {
  EXPECT_NEAR(interval_p_value(1.959964, 0, 1), 0.05, 1e-7);         // no interval: two sides
  EXPECT_NEAR(interval_p_value(-10 - 1.644854, 10, 1), 0.05, 1e-7);  // a wide one: the far side is nowhere
  EXPECT_NEAR(interval_p_value(2 * 2.5, 2 * 0.5, 2), normal_tail(2) + normal_tail(3), 1e-15);
  EXPECT_GT(interval_p_value(9, 10, 1), 0.8);
  EXPECT_EQ(interval_p_value(1, 1, 0), 1);
  EXPECT_EQ(interval_p_value(1.001, 1, 0), 0);
  for (const double tail : {0.5, 0.05, 1e-3, 1e-9}) {
    EXPECT_NEAR(normal_tail(normal_quantile(tail)) / tail, 1, 1e-9);
  }
}

TEST(PValues, OfStudentsDistributionAreThoseOfItsTables) {
  EXPECT_NEAR(student_tail(12.706, 1), 0.025, 1e-5);
  EXPECT_NEAR(student_tail(9.925, 2), 0.005, 1e-5);
  EXPECT_NEAR(student_tail(2.0395, 31), 0.025, 1e-5);
  EXPECT_NEAR(student_tail(3.646, 30), 0.0005, 1e-6);
  EXPECT_NEAR(student_tail(-2.0395, 31), 0.975, 1e-5);
  EXPECT_NEAR(student_tail(2, 1000001), normal_tail(2), 1e-6);
  EXPECT_NEAR(interval_p_value(2.0395 + 8, 8, 1, 31), 0.025, 1e-5);
}

TEST(PValues, AreCombinedAsPublished) {
  // exp(-x / 2) (1 + x / 2), the tail of chi-square with four degrees of freedom.
  const double two[] = {0.05, 0.05}, one[] = {0.3};
  EXPECT_NEAR(fisher_p_value(two), 0.0025 * (1 - std::log(0.0025)), 1e-12);
  EXPECT_NEAR(fisher_p_value(one), 0.3, 1e-12);
  const double four[] = {0.01, 0.04, 0.03, 0.005};
  const std::vector<double> adjusted = holm_adjusted(four);
  EXPECT_DOUBLE_EQ(adjusted[0], 0.03);
  EXPECT_DOUBLE_EQ(adjusted[1], 0.06);
  EXPECT_DOUBLE_EQ(adjusted[2], 0.06);  // not below that of the smaller p-value
  EXPECT_DOUBLE_EQ(adjusted[3], 0.02);
  EXPECT_NEAR(binomial_tail(1, 10, 0.1), 1 - std::pow(0.9, 10), 1e-12);
  EXPECT_NEAR(binomial_tail(10, 10, 0.1), 1e-10, 1e-20);
  EXPECT_EQ(binomial_tail(0, 1000, 0.3), 1);
}

constexpr std::size_t kWidth = 20, kHeight = 12;  // six blocks, ragged on both sides
constexpr double kSpp = 100, kVariance = 0.25;

/// A grey reference without noise, and images whose noise is grey as well: X, Y and Z have one p-value.
class ImageAgreementTest : public testing::Test {
 protected:
  static RgbPlanes filled(double value) {
    return {kWidth, kHeight, std::vector<double>(3 * kWidth * kHeight, value)};
  }

  /// An image of the mean `bias` times the reference's; its noise is `noise` times what it should be.
  RgbPlanes image(double bias, double noise = 1) {
    RgbPlanes image = reference_.mean;
    for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
      const double error = noise * std::sqrt(kVariance / kSpp) * normal_(random_);
      for (std::size_t c = 0; c < 3; ++c) image.rgb[i + c] = bias * image.rgb[i + c] + error;
    }
    return image;
  }
  ImageAgreement judge(const RgbPlanes& image) const {
    return agreement(reference_, image, variance_, {.spp = kSpp});
  }

  std::mt19937_64 random_{1};
  std::normal_distribution<double> normal_;
  const RgbPlanes variance_ = filled(kVariance);
  ReferenceImage reference_{filled(0.5), filled(0), 32000};
};

TEST_F(ImageAgreementTest, RejectsAsOftenAsItSaysWhereTheErrorIsAllThatIsAllowed) {
  // The mean is off by the whole tolerance. A third of the level is for each of X, Y and Z, which here are
  // one; of six blocks each has a sixth of that.
  constexpr int kImages = 10'000;
  constexpr double kLevel = 0.05, kWhole = kLevel / 3;
  const double blocks = 1 - std::pow(1 - kLevel / 18, 6);
  int whole_rejected = 0, blocks_rejected = 0, rejected = 0;
  for (int i = 0; i < kImages; ++i) {
    const ImageAgreement result = judge(image(1.001));
    whole_rejected += result.whole <= kLevel;
    blocks_rejected += result.blocks <= kLevel;
    rejected += result.p_value() <= kLevel;
  }
  // Four standard errors of a count; kRounding takes 2 % of the tolerance, and as much of the standard error
  // of the whole, hence 5 % of its level.
  const auto noise = [](double p) { return 4 * std::sqrt(kImages * p * (1 - p)); };
  EXPECT_NEAR(whole_rejected, kImages * kWhole, noise(kWhole) + 0.05 * kImages * kWhole);
  EXPECT_NEAR(blocks_rejected, kImages * blocks, noise(blocks) + 0.05 * kImages * blocks);
  EXPECT_LE(rejected, kImages * kLevel);
  EXPECT_GT(rejected, 0);
}

TEST_F(ImageAgreementTest, SeesAShiftThatNoPixelAndNoBlockShows) {
  // The standard error of the mean of 240 pixels is 0.65 % of it.
  const ImageAgreement result = judge(image(1.05));
  EXPECT_GT(result.pixels, 0.01);
  EXPECT_LT(result.whole, 1e-6);
  EXPECT_LT(result.p_value(), 1e-6);
}

TEST_F(ImageAgreementTest, SeesAnErrorOfOneBlock) {
  RgbPlanes wrong = image(1);
  for (std::size_t y = 0; y < 8; ++y) {
    for (std::size_t x = 8; x < 16; ++x) {
      for (std::size_t c = 0; c < 3; ++c) wrong.rgb[3 * (y * kWidth + x) + c] += 0.05;
    }
  }
  EXPECT_LT(judge(wrong).blocks, 1e-6);
}

TEST_F(ImageAgreementTest, SeesNoiseThatIsLargerThanTheVarianceSays) {
  EXPECT_LT(judge(image(1, 4)).pixels, 1e-6);
}

TEST_F(ImageAgreementTest, SeesAPixelThatIsNotANumber) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    RgbPlanes wrong = image(1);
    wrong.rgb[3 * 7 + 1] = bad;
    EXPECT_EQ(judge(wrong).p_value(), 0);
  }
}

TEST_F(ImageAgreementTest, PicturesWithoutNoiseAgreeWithinTheTolerance) {
  const RgbPlanes none = filled(0);
  EXPECT_EQ(agreement(reference_, filled(0.5 * 1.001), none, {.spp = kSpp}).p_value(), 1);
  EXPECT_EQ(agreement(reference_, filled(0.5 * 1.0011), none, {.spp = kSpp}).p_value(), 0);
}

TEST_F(ImageAgreementTest, NoiseOfTheReferenceIsAllowed) {
  // One image held against many references: off by up to three of their standard errors, as a whole.
  const RgbPlanes exact = filled(0.5);
  reference_.variance = filled(0.25);
  const double error = std::sqrt(0.25 / reference_.spp / (kWidth * kHeight));
  reference_.mean = filled(0.5 * 1.001 + 3 * error);
  EXPECT_GT(agreement(reference_, exact, filled(1e-12), {.spp = 1e9}).p_value(), 0.9);
}

}  // namespace
}  // namespace tessera::test
