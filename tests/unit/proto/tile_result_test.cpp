#include "wire/tile_result.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <random>

#include "wire/aov_channels.h"
#include "wire/enum_words.h"

namespace tessera::wire {
namespace {

using testing::HasSubstr;

TileResult sample_result() {
  TileResult result;
  result.x0 = 16, result.y0 = 32, result.x1 = 27, result.y1 = 40;
  result.sample_begin = 8, result.sample_end = 16;
  result.channels = channels_for_aovs({v1::AOV_VARIANCE, v1::AOV_DEPTH});
  result.counts.assign(result.pixel_count(), 8);
  result.values.resize(result.pixel_count() * result.channels.size());
  std::mt19937 random(3);
  std::normal_distribution<float> value(1.0f, 10.0f);
  for (float& x : result.values) x = value(random);
  // Bit patterns that must come through as they are.
  result.values[0] = -0.0f;
  result.values[1] = std::numeric_limits<float>::denorm_min();
  result.values[2] = std::numeric_limits<float>::infinity();
  result.values[3] = std::numeric_limits<float>::quiet_NaN();
  return result;
}

class TileResultPacking : public testing::TestWithParam<Packing> {};

INSTANTIATE_TEST_SUITE_P(, TileResultPacking, testing::Values(Packing::kZstd, Packing::kNone));

TEST_P(TileResultPacking, RoundTripsBitForBit) {
  const TileResult result = sample_result();
  const auto decoded = decode_tile_result(encode_tile_result(result, GetParam()));
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(decoded->x0, result.x0);
  EXPECT_EQ(decoded->y0, result.y0);
  EXPECT_EQ(decoded->x1, result.x1);
  EXPECT_EQ(decoded->y1, result.y1);
  EXPECT_EQ(decoded->sample_begin, result.sample_begin);
  EXPECT_EQ(decoded->sample_end, result.sample_end);
  EXPECT_EQ(decoded->channels, result.channels);
  EXPECT_EQ(decoded->counts, result.counts);
  ASSERT_EQ(decoded->values.size(), result.values.size());
  EXPECT_EQ(std::memcmp(decoded->values.data(), result.values.data(), 4 * result.values.size()), 0);
}

TEST_P(TileResultPacking, RefusesMorePixelsThanExpected) {
  const TileResult result = sample_result();
  const std::string bytes = encode_tile_result(result, GetParam());
  EXPECT_TRUE(decode_tile_result(bytes, result.pixel_count()).ok());
  EXPECT_THAT(std::string(decode_tile_result(bytes, result.pixel_count() - 1).status().message()),
              HasSubstr("pixels"));
}

// A zstd frame has a few bits without a meaning; whatever is taken must be the same result.
TEST(TileResult, RefusesMoreChannelsThanExpected) {
  const TileResult result = sample_result();
  const std::string bytes = encode_tile_result(result);
  EXPECT_TRUE(decode_tile_result(bytes, result.pixel_count(), result.channels.size()).ok());
  const auto fewer = decode_tile_result(bytes, result.pixel_count(), result.channels.size() - 1);
  EXPECT_THAT(std::string(fewer.status().message()), HasSubstr("channels"));
}

TEST(TileResult, EveryFlippedByteIsNoticedOrMeansNothing) {
  const TileResult result = sample_result();
  const std::string sound = encode_tile_result(result);
  int meaningless = 0;
  for (std::size_t at = 0; at < sound.size(); ++at) {
    std::string bytes = sound;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x10);
    const auto decoded = decode_tile_result(bytes);
    if (!decoded.ok()) continue;
    ++meaningless;
    EXPECT_EQ(decoded->x0, result.x0);
    EXPECT_EQ(decoded->sample_end, result.sample_end);
    EXPECT_EQ(decoded->channels, result.channels);
    EXPECT_EQ(decoded->counts, result.counts);
    EXPECT_EQ(std::memcmp(decoded->values.data(), result.values.data(), 4 * result.values.size()), 0);
  }
  EXPECT_LE(meaningless, 4);
}

TEST_P(TileResultPacking, EveryCutIsNoticed) {
  const std::string sound = encode_tile_result(sample_result(), GetParam());
  for (std::size_t size = 0; size < sound.size(); ++size) {
    EXPECT_FALSE(decode_tile_result(std::string_view(sound).substr(0, size)).ok()) << size;
  }
  EXPECT_FALSE(decode_tile_result(sound + "x").ok());
}

TEST_P(TileResultPacking, AHugeClaimAllocatesNothing) {
  std::string bytes = encode_tile_result(sample_result(), GetParam());
  const std::uint32_t huge = 4'000'000'000u;
  std::memcpy(bytes.data() + 16, &huge, 4);  // x1
  std::memcpy(bytes.data() + 20, &huge, 4);  // y1
  EXPECT_THAT(std::string(decode_tile_result(bytes).status().message()), HasSubstr("pixels"));
  const std::uint32_t many = 1u << 12;
  const std::uint32_t zero = 0;
  std::memcpy(bytes.data() + 8, &zero, 4);
  std::memcpy(bytes.data() + 12, &zero, 4);
  std::memcpy(bytes.data() + 16, &many, 4);
  std::memcpy(bytes.data() + 20, &many, 4);
  EXPECT_THAT(std::string(decode_tile_result(bytes).status().message()), HasSubstr("size"));
}

TEST(TileResult, ChannelsComeInOneOrder) {
  const auto names = [](const std::vector<v1::AOV>& aovs) {
    std::vector<std::string> result;
    for (const ChannelDesc& channel : channels_for_aovs(aovs)) result.push_back(channel.name);
    return result;
  };
  EXPECT_THAT(names({}), testing::ElementsAre("R", "G", "B", "A"));
  EXPECT_THAT(names({v1::AOV_DEPTH, v1::AOV_SAMPLES, v1::AOV_VARIANCE, v1::AOV_DEPTH}),
              testing::ElementsAre("R", "G", "B", "A", "variance.R", "variance.G", "variance.B", "depth.Z"));
  EXPECT_THAT(names({v1::AOV_NORMAL, v1::AOV_ALBEDO}),
              testing::ElementsAre("R", "G", "B", "A", "albedo.R", "albedo.G", "albedo.B", "normal.X",
                                   "normal.Y", "normal.Z"));
  const auto channels = channels_for_aovs({v1::AOV_VARIANCE});
  EXPECT_EQ(channels[6].kind, ChannelKind::kSquaredDeviation);
  EXPECT_EQ(channels[6].of, 2);
}

/// Kernels put the values of first hits in the order of the list, and channels are in that of the numbers.
TEST(TileResult, FirstHitsAreListedInTheOrderOfTheirNumbers) {
  std::size_t row_number = 0;
  int last = 0;
  for (const HitAovRow& row : kHitAovs) {
    EXPECT_EQ(static_cast<std::size_t>(row.aov), row_number++) << row.word;
    const absl::StatusOr<v1::AOV> aov = value_of<v1::AOV>(row.word);
    ASSERT_TRUE(aov.ok()) << row.word;
    EXPECT_GT(*aov, last) << row.word;
    last = *aov;
  }
}

}  // namespace
}  // namespace tessera::wire
