#include "service/result_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "wire/digest.h"

namespace tessera::server {
namespace {

class ResultCheckTest : public testing::Test {
 protected:
  ResultCheckTest() {
    v1::PixelRect& pixels = *extent_.mutable_pixels();
    pixels.set_x0(8), pixels.set_y0(16), pixels.set_x1(12), pixels.set_y1(19);
    extent_.mutable_samples()->set_begin(4);
    extent_.mutable_samples()->set_end(8);
    result_.x0 = 8, result_.y0 = 16, result_.x1 = 12, result_.y1 = 19;
    result_.sample_begin = 4, result_.sample_end = 8;
    result_.channels = channels_;
    result_.counts.assign(12, 4);
    result_.values.assign(12 * 4, 0.25f);
  }

  std::string message() {
    const auto digest = check_result(wire::encode_tile_result(result_), 0, extent_, channels_);
    EXPECT_EQ(digest.status().code(), absl::StatusCode::kInvalidArgument);
    return std::string(digest.status().message());
  }

  const std::vector<wire::ChannelDesc> channels_ = wire::channels_for_aovs({}).value();
  v1::TileUnit extent_;
  wire::TileResult result_;
};

TEST_F(ResultCheckTest, DigestsTheContents) {
  const auto digest = check_result(wire::encode_tile_result(result_), 0, extent_, channels_);
  ASSERT_TRUE(digest.ok()) << digest.status();
  EXPECT_TRUE(wire::is_digest(*digest));
  result_.values[47] = -0.25f;
  EXPECT_NE(check_result(wire::encode_tile_result(result_), 0, extent_, channels_).value(), *digest);
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
  result_.counts[3] = 0;
  EXPECT_TRUE(check_result(wire::encode_tile_result(result_), 0, extent_, channels_).ok());
  result_.y1 = 20;
  result_.counts.resize(16), result_.values.resize(16 * 4);
  EXPECT_THAT(message(), HasSubstr("pixels"));
}

TEST_F(ResultCheckTest, RefusesWhatIsNoNumber) {
  result_.values[12 + 3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(message(), testing::HasSubstr("channel G holds a NaN"));
}

}  // namespace
}  // namespace tessera::server
