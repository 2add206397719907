#include "service/job/result_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "wire/aov_channels.h"
#include "wire/digest.h"

namespace tessera::server {
namespace {

class ResultCheckTest : public testing::Test {
 protected:
  ResultCheckTest() {
    v1::PixelRect& pixels = *unit_.mutable_tile()->mutable_pixels();
    pixels.set_x0(8), pixels.set_y0(16), pixels.set_x1(12), pixels.set_y1(19);
    unit_.mutable_tile()->mutable_samples()->set_begin(4);
    unit_.mutable_tile()->mutable_samples()->set_end(8);
    result_.x0 = 8, result_.y0 = 16, result_.x1 = 12, result_.y1 = 19;
    result_.sample_begin = 4, result_.sample_end = 8;
    result_.channels = channels_;
    result_.counts.assign(12, 4);
    result_.values.assign(12 * 4, 0.25f);
  }

  absl::StatusOr<std::string> check() {
    return check_result(wire::encode_tile_result(result_), unit_, spec_, channels_);
  }
  std::string message() {
    const auto digest = check();
    EXPECT_EQ(digest.status().code(), absl::StatusCode::kInvalidArgument);
    return std::string(digest.status().message());
  }

  std::vector<wire::ChannelDesc> channels_ = wire::channels_for_aovs({});
  v1::JobSpec spec_;
  v1::WorkUnit unit_;
  wire::TileResult result_;
};

TEST_F(ResultCheckTest, DigestsTheContents) {
  const auto digest = check();
  ASSERT_TRUE(digest.ok()) << digest.status();
  EXPECT_TRUE(wire::is_digest(*digest));
  result_.values[47] = -0.25f;
  EXPECT_NE(check().value(), *digest);
}

TEST_F(ResultCheckTest, NamesWhatDoesNotFit) {
  using testing::HasSubstr;
  result_.x0 = 7, result_.x1 = 11;
  EXPECT_THAT(message(), HasSubstr("rectangle"));
  result_.x0 = 8, result_.x1 = 12;
  result_.sample_end = 9;
  EXPECT_THAT(message(), HasSubstr("range"));
  result_.sample_end = 8;
  result_.channels[0].name = "X";
  EXPECT_THAT(message(), HasSubstr("channels"));
  result_.channels = channels_;
  result_.counts[3] = 5;
  EXPECT_THAT(message(), HasSubstr("samples"));
  for (const std::uint32_t few : {0, 3}) {
    result_.counts[3] = few;
    EXPECT_THAT(message(), HasSubstr("fewer samples"));
  }
  result_.counts[3] = 4;
  result_.y1 = 20;
  result_.counts.resize(16), result_.values.resize(16 * 4);
  EXPECT_THAT(message(), HasSubstr("pixels"));
}

TEST_F(ResultCheckTest, AdaptivePixelsHaveTheLeastNumberOfSamples) {
  spec_.mutable_samples()->set_noise(0.01f);
  unit_.mutable_tile()->mutable_samples()->set_begin(0);
  unit_.mutable_tile()->mutable_samples()->set_end(64);
  result_.sample_begin = 0, result_.sample_end = 64;
  result_.counts.assign(12, 8);  // wire::kLeastNoiseSamples
  result_.counts[1] = 64;
  EXPECT_TRUE(check().ok()) << check().status();
  for (const std::uint32_t few : {0, 7}) {
    result_.counts[3] = few;
    EXPECT_THAT(message(), testing::HasSubstr("fewer samples"));
  }
}

TEST_F(ResultCheckTest, RefusesWhatNoRendererReturns) {
  using testing::HasSubstr;
  float& value = result_.values[12 + 3];
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity()}) {
    value = bad;
    EXPECT_THAT(message(), HasSubstr("channel G holds a value that is not finite"));
  }
  // Four samples of 1e15 at most, weighed by 4 at most.
  for (const float bad : {1e38f, -1e38f, 1.7e16f, -1.7e16f}) {
    value = bad;
    EXPECT_THAT(message(), HasSubstr("channel G holds a value that no samples add up to")) << bad;
  }
  for (const float good :
       {1.6e16f, -1.6e16f, -0.25f, 0.0f}) {  // filters with negative lobes make negative sums
    value = good;
    EXPECT_TRUE(check().ok()) << good;
  }
}

TEST_F(ResultCheckTest, SquaresAreNotNegativeAndNormalsMayBe) {
  channels_ = result_.channels = wire::channels_for_aovs({v1::AOV_VARIANCE, v1::AOV_NORMAL});
  result_.values.assign(12 * channels_.size(), 0.25f);
  const auto first_of = [&](const char* name) {
    const auto found =
        std::find_if(channels_.begin(), channels_.end(), [&](const auto& c) { return c.name == name; });
    return result_.values.begin() + 12 * (found - channels_.begin());
  };
  *first_of("normal.X") = -4;
  *first_of("variance.R") = 1e37f;
  EXPECT_TRUE(check().ok()) << check().status();
  *first_of("variance.R") = -1e-3f;
  EXPECT_THAT(message(), testing::HasSubstr("channel variance.R holds"));
  *first_of("variance.R") = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(message(), testing::HasSubstr("channel variance.R holds"));
}

TEST_F(ResultCheckTest, AnyNumberOfSamplesOfAPassLandsOnOnePixel) {
  spec_.mutable_content()->mutable_algorithms()->set_integrator("light");
  spec_.mutable_cut()->mutable_crop()->CopyFrom(unit_.tile().pixels());
  const v1::SampleRange samples = unit_.tile().samples();
  *unit_.mutable_pass()->mutable_passes() = samples;
  result_.values[5] = 1e30f;
  EXPECT_TRUE(check().ok()) << check().status();
  result_.values[5] = std::numeric_limits<float>::infinity();
  EXPECT_THAT(message(), testing::HasSubstr("not finite"));
}

}  // namespace
}  // namespace tessera::server
