#include "support/ztest.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <limits>

namespace tessera::test {
namespace {

constexpr std::size_t kWidth = 20, kHeight = 12;  // blocks of 8 are ragged on both sides

/// Numbers in [0, 1), the same in the program that the expected values come from.
class Numbers {
 public:
  double next() {
    state_ = (1103515245 * state_ + 12345) % (std::uint64_t{1} << 31);
    return static_cast<double>(state_) / static_cast<double>(std::uint64_t{1} << 31);
  }
  ZImage image(const std::function<double(double)>& value) {
    ZImage image{kWidth, kHeight, {}};
    for (std::size_t i = 0; i < 3 * kWidth * kHeight; ++i) image.rgb.push_back(value(next()));
    return image;
  }

 private:
  std::uint64_t state_ = 12345;
};

/// The images of all cases, and what they are tested with.
class ZTest : public testing::Test {
 protected:
  ZResult run(const std::function<double(double reference, double noise, std::size_t i)>& value) const {
    ZImage tested{kWidth, kHeight, {}};
    for (std::size_t i = 0; i < reference_.rgb.size(); ++i) {
      tested.rgb.push_back(value(reference_.rgb[i], noise_.rgb[i], i));
    }
    ZOptions options;
    options.spp = 100;
    return z_test(reference_, reference_variance_, tested, variance_, options);
  }

  Numbers numbers_;
  ZImage reference_ = numbers_.image([](double u) { return u; });
  ZImage reference_variance_ = numbers_.image([](double u) { return 0.5 + u; });
  ZImage noise_ = numbers_.image([](double u) { return u - 0.5; });
  ZImage variance_ = numbers_.image([](double u) { return 0.25 + 0.5 * u; });
};

// The expected numbers come from a second program for the same rules, in double precision; sums are in
// another order.
constexpr double kRounding = 1e-9;

TEST_F(ZTest, AcceptsNoiseOfTheRightSize) {
  const ZResult result = run([](double r, double noise, std::size_t) { return r + noise * 0.3; });
  EXPECT_TRUE(result.pass()) << result.report();
  EXPECT_NEAR(result.suite.max_z, 1.7261797088542825, kRounding);
  EXPECT_NEAR(result.own.max_z, 2.8589746283858135, kRounding);
  EXPECT_NEAR(result.block.max_z, 1.784556696706734, kRounding);
  EXPECT_NEAR(result.global.max_z, 1.9677059090303417, kRounding);
  EXPECT_NEAR(result.bias_percent[0], 1.8789103455640352, kRounding);
  EXPECT_NEAR(result.bias_percent[2], -1.875245684746494, kRounding);
}

TEST_F(ZTest, SumsShowASmallShiftThatPixelsHide) {
  const ZResult result = run([](double r, double noise, std::size_t) { return r * 1.05 + noise * 0.1; });
  EXPECT_TRUE(result.suite.pass);
  EXPECT_TRUE(result.own.pass);
  EXPECT_TRUE(result.block.pass);
  EXPECT_FALSE(result.global.pass);
  EXPECT_EQ(result.global.accepted, 0);
  EXPECT_NEAR(result.block.max_z, 3.3252581036486366, kRounding);
  EXPECT_NEAR(result.global.max_z, 6.025632722985782, kRounding);
  EXPECT_FALSE(result.pass());
}

TEST_F(ZTest, ABadPixelFails) {
  const ZResult result = run([](double r, double, std::size_t i) {
    return i / 3 == 7 ? std::numeric_limits<double>::quiet_NaN() : r;
  });
  EXPECT_EQ(result.bad_pixels, 1u);
  EXPECT_FALSE(result.pass());
  // One of 240 pixels.
  EXPECT_NEAR(result.suite.accepted, 0.9958333333333333, kRounding);
  EXPECT_NEAR(result.own.accepted, 0.9958333333333333, kRounding);
  EXPECT_FALSE(result.suite.pass);
}

}  // namespace
}  // namespace tessera::test
