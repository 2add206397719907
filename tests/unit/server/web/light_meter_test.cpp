#include "service/web/light_meter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace tessera::server {
namespace {

using wire::ChannelKind;

const std::vector<wire::ChannelDesc> kColors = {{"R"},
                                                {"G"},
                                                {"B"},
                                                {"A"},
                                                {"variance.R", ChannelKind::kSquaredDeviation, 0},
                                                {"variance.G", ChannelKind::kSquaredDeviation, 1},
                                                {"variance.B", ChannelKind::kSquaredDeviation, 2}};
constexpr std::array<double, 3> kWeights = {0.2126, 0.7152, 0.0722};

/// Sample `index` of a pixel: no two pixels have the same.
double sample(std::uint32_t x, std::uint32_t y, std::size_t band, std::uint32_t index) {
  return 1 + x + 0.5 * y + 0.25 * static_cast<double>(band) + std::sin(1.7 * index + x + 2 * y);
}

struct Moments {
  double count = 0, mean = 0, deviations = 0;
};

Moments moments_of(std::uint32_t x, std::uint32_t y, std::size_t band, std::uint32_t first,
                   std::uint32_t end) {
  Moments of;
  for (std::uint32_t i = first; i < end; ++i) of.mean += sample(x, y, band, i);
  of.count = end - first;
  of.mean /= of.count;
  for (std::uint32_t i = first; i < end; ++i) of.deviations += std::pow(sample(x, y, band, i) - of.mean, 2);
  return of;
}

/// A result of the samples from `first` to `end` of an area.
wire::TileResult result_of(const PixelArea& area, std::uint32_t first, std::uint32_t end) {
  wire::TileResult result;
  result.x0 = area.x0, result.y0 = area.y0, result.x1 = area.x1, result.y1 = area.y1;
  result.channels = kColors;
  result.counts.assign(result.pixel_count(), end - first);
  for (std::size_t c = 0; c < kColors.size(); ++c) {
    for (std::uint32_t y = area.y0; y < area.y1; ++y) {
      for (std::uint32_t x = area.x0; x < area.x1; ++x) {
        const Moments of = moments_of(x, y, c % 4, first, end);
        result.values.push_back(static_cast<float>(c < 4 ? of.mean * of.count : of.deviations));
      }
    }
  }
  return result;
}

double error_of(std::uint32_t x, std::uint32_t y, std::uint32_t count) {
  double error = 0;
  for (std::size_t band = 0; band < 3; ++band)
    error += kWeights[band] * std::sqrt(moments_of(x, y, band, 0, count).deviations / (count - 1) / count);
  return error;
}

// Sums and deviations are floats, of 24 bits: off by some 2^-24 of themselves each, of which the square root
// of deviations keeps half.
constexpr double kFloats = 1e-6;

TEST(LightMeter, IsTheMeanOfAllSamplesWithItsError) {
  const PixelArea area{8, 16, 12, 18};
  LightMeter meter(area, *meter_channels(kColors));
  // Results of other sample ranges, in no order; one is larger than what is looked at.
  meter.add(result_of({0, 0, 16, 32}, 8, 16));
  meter.add(result_of(area, 0, 8));
  meter.add(result_of({8, 16, 10, 17}, 16, 32));
  meter.add(result_of({10, 16, 12, 17}, 16, 32));
  meter.add(result_of({8, 17, 12, 18}, 16, 32));
  meter.add(result_of({0, 0, 4, 4}, 16, 32));
  const LightReading pixel = meter.read({9, 17, 10, 18}, kWeights, false);
  EXPECT_EQ(pixel.samples, 32u);
  EXPECT_EQ(pixel.pixels, 1u);
  double luminance = 0;
  for (std::size_t band = 0; band < 3; ++band) {
    const double mean = moments_of(9, 17, band, 0, 32).mean;
    EXPECT_NEAR(pixel.color[band], mean, kFloats * mean);
    luminance += kWeights[band] * mean;
  }
  EXPECT_NEAR(pixel.luminance, luminance, kFloats * luminance);
  ASSERT_TRUE(pixel.error.has_value());
  EXPECT_NEAR(*pixel.error, error_of(9, 17, 32), kFloats * luminance);
}

TEST(LightMeter, OfABlockHasTheErrorOfItsMean) {
  const PixelArea area{8, 16, 12, 18};
  LightMeter meter(area, *meter_channels(kColors));
  meter.add(result_of(area, 0, 16));
  double squares = 0, sum = 0;
  for (std::uint32_t y = 16; y < 18; ++y) {
    for (std::uint32_t x = 8; x < 12; ++x)
      squares += std::pow(error_of(x, y, 16), 2), sum += error_of(x, y, 16);
  }
  const LightReading apart = meter.read(area, kWeights, false), together = meter.read(area, kWeights, true);
  EXPECT_EQ(apart.pixels, 8u);
  EXPECT_EQ(apart.samples, 8 * 16u);
  EXPECT_NEAR(*apart.error, std::sqrt(squares) / 8, kFloats);
  EXPECT_NEAR(*together.error, sum / 8, kFloats) << "pixels that share samples may err together";
}

TEST(LightMeter, TellsNoErrorWhereThereIsNone) {
  const PixelArea area{0, 0, 2, 1};
  LightMeter meter(area, *meter_channels(kColors));
  EXPECT_EQ(meter.read(area, kWeights, false).pixels, 0u) << "nothing yet";
  meter.add(result_of({0, 0, 1, 1}, 0, 1));
  EXPECT_FALSE(meter.read(area, kWeights, false).error.has_value()) << "one sample";
  EXPECT_EQ(meter.read(area, kWeights, false).pixels, 1u) << "the other pixel has no samples";
  const std::vector<wire::ChannelDesc> plain(kColors.begin(), kColors.begin() + 4);
  LightMeter other(area, *meter_channels(plain));
  wire::TileResult result = result_of(area, 0, 8);
  result.channels = plain;
  result.values.resize(4 * result.pixel_count());
  other.add(result);
  EXPECT_FALSE(other.read(area, kWeights, false).error.has_value()) << "no variance";
  EXPECT_EQ(other.read(area, kWeights, false).samples, 16u);
}

TEST(LightMeter, LeavesOutResultsOfOtherChannels) {
  const PixelArea area{0, 0, 1, 1};
  LightMeter meter(area, *meter_channels(kColors));
  wire::TileResult result = result_of(area, 0, 8);
  result.channels.resize(2);
  result.values.resize(2);
  meter.add(result);
  EXPECT_EQ(meter.read(area, kWeights, false).samples, 0u);
  EXPECT_FALSE(meter_channels({{"depth.Z"}}).has_value());
}

}  // namespace
}  // namespace tessera::server
