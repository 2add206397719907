#include "service/web/picture.h"

#include <Imath/half.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

namespace tessera::server {
namespace {

using wire::ChannelKind;

const std::vector<wire::ChannelDesc> kChannels = {{"R"}, {"G"},       {"B"},
                                                  {"A"}, {"depth.Z"}, {"id.shape", ChannelKind::kFirst}};

PictureLayer layer(const std::string& name) {
  for (const PictureLayer& found : layers_of(kChannels, /*has_pilot=*/false)) {
    if (found.name == name) return found;
  }
  ADD_FAILURE() << name;
  return {};
}

/// `count` samples a pixel of value(x, y, channel).
template <class Value>
wire::TileResult tile(const PixelArea& area, std::uint32_t count, Value&& value) {
  wire::TileResult result;
  result.x0 = area.x0, result.y0 = area.y0, result.x1 = area.x1, result.y1 = area.y1;
  result.channels = kChannels;
  for (std::size_t c = 0; c < kChannels.size(); ++c) {
    const float scale = kChannels[c].kind == ChannelKind::kSum ? static_cast<float>(count) : 1.f;
    for (std::uint32_t y = area.y0; y < area.y1; ++y)
      for (std::uint32_t x = area.x0; x < area.x1; ++x)
        result.values.push_back(scale * static_cast<float>(value(x, y, c)));
  }
  result.counts.assign(result.pixel_count(), count);
  return result;
}

std::vector<float> scalars(const std::string& bytes) {
  std::vector<float> values(bytes.size() / sizeof(float));
  std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

std::vector<float> halves(const std::string& bytes) {
  std::vector<std::uint16_t> bits(bytes.size() / 2);
  std::memcpy(bits.data(), bytes.data(), bytes.size());
  std::vector<float> values;
  for (const std::uint16_t half : bits) values.push_back(imath_half_to_float(half));
  return values;
}

TEST(Picture, ListsLayersOfChannels) {
  std::vector<std::string> names;
  for (const PictureLayer& found : layers_of(kChannels, /*has_pilot=*/false)) names.push_back(found.name);
  EXPECT_THAT(names, testing::ElementsAre("color", "alpha", "depth", "id.shape", "noise", "samples", "cost"));
}

TEST(Picture, IsTheMeanOfAllResults) {
  Picture picture({10, 20, 14, 22}, 0, layer("color"));
  // 3 samples of 1 and 1 of 5: a mean of 2.
  ASSERT_TRUE(picture.add(tile({10, 20, 12, 22}, 3, [](auto, auto, auto) { return 1; }), 0).ok());
  ASSERT_TRUE(picture.add(tile({10, 20, 12, 22}, 1, [](auto, auto, auto) { return 5; }), 0).ok());
  const std::vector<float> values = halves(picture.pixels(0, {1, 0, 3, 1}));
  EXPECT_THAT(values, testing::ElementsAre(2, 2, 2, 1, 0, 0, 0, 0)) << "the second pixel has no samples";
}

TEST(Picture, LevelsAreMeansOfPixels) {
  const PixelArea area{0, 0, 7, 5};  // not a multiple of 4
  const auto value = [](std::uint32_t x, std::uint32_t y, std::size_t) { return x + 10 * y; };
  for (const std::uint32_t kept : {0u, 1u}) {
    Picture picture(area, kept, layer("depth"));
    ASSERT_TRUE(picture.add(tile(area, 2, value), 0).ok());
    const std::vector<float> level2 = scalars(picture.pixels(2, {0, 0, 2, 2}));
    // Means over x of 0..3 and 4..6, over y of 0..3 and 4.
    EXPECT_THAT(level2, testing::Pointwise(testing::FloatEq(), {1.5f + 15, 5 + 15.f, 1.5f + 40, 5 + 40.f}))
        << kept;
  }
}

TEST(Picture, KeepsNumbersThatHaveNoMean) {
  Picture picture({0, 0, 2, 1}, 0, layer("id.shape"));
  ASSERT_TRUE(picture.add(tile({0, 0, 2, 1}, 4, [](auto x, auto, auto) { return 7 + x; }), 0).ok());
  ASSERT_TRUE(picture.add(tile({0, 0, 2, 1}, 4, [](auto, auto, auto) { return 100; }), 0).ok());
  EXPECT_THAT(scalars(picture.pixels(0, {0, 0, 2, 1})), testing::ElementsAre(7, 8));
  EXPECT_THAT(scalars(picture.pixels(1, {0, 0, 1, 1})), testing::ElementsAre(7));
}

TEST(Picture, NoiseIsTheStandardErrorBetweenResults) {
  Picture picture({0, 0, 1, 1}, 0, layer("noise"));
  ASSERT_TRUE(picture.add(tile({0, 0, 1, 1}, 4, [](auto, auto, auto) { return 1; }), 0).ok());
  EXPECT_TRUE(std::isnan(scalars(picture.pixels(0, {0, 0, 1, 1}))[0])) << "one result says nothing";
  ASSERT_TRUE(picture.add(tile({0, 0, 1, 1}, 4, [](auto, auto, auto) { return 3; }), 0).ok());
  // Two means, 1 and 3: variance 2 between them, of their mean 1.
  EXPECT_NEAR(scalars(picture.pixels(0, {0, 0, 1, 1}))[0], 1, 1e-6);
}

TEST(Picture, NoiseOfOneResultIsThatOfItsSamples) {
  const std::vector<wire::ChannelDesc> channels = {{"R"},
                                                   {"G"},
                                                   {"B"},
                                                   {"A"},
                                                   {"variance.R", ChannelKind::kSquaredDeviation, 0},
                                                   {"variance.G", ChannelKind::kSquaredDeviation, 1},
                                                   {"variance.B", ChannelKind::kSquaredDeviation, 2}};
  const std::vector<PictureLayer> layers = layers_of(channels, /*has_pilot=*/true);
  const auto noise = std::ranges::find(layers, "noise", &PictureLayer::name);
  ASSERT_NE(noise, layers.end());
  EXPECT_EQ(noise->noise, PictureLayer::Noise::kVariance);
  // Four samples 0, 0, 2, 2 in each channel: squared deviations of 4, a variance of 4/3, of their mean 1/3.
  wire::TileResult result{.x0 = 0, .y0 = 0, .x1 = 1, .y1 = 1, .channels = channels, .counts = {4}};
  result.values = {4, 4, 4, 4, 4, 4, 4};
  Picture picture({0, 0, 1, 1}, 0, *noise);
  ASSERT_TRUE(picture.add(result, 0).ok());
  EXPECT_NEAR(scalars(picture.pixels(0, {0, 0, 1, 1}))[0], std::sqrt(1 / 3.0), 1e-6);
  Picture none({0, 0, 1, 1}, 0, *noise);
  result.counts = {1};
  ASSERT_TRUE(none.add(result, 0).ok());
  EXPECT_TRUE(std::isnan(scalars(none.pixels(0, {0, 0, 1, 1}))[0])) << "one sample says nothing";
}

TEST(Picture, NoiseIsWhatThePilotForesaw) {
  const std::vector<PictureLayer> layers = layers_of(kChannels, /*has_pilot=*/true);
  const auto noise = std::ranges::find(layers, "noise", &PictureLayer::name);
  ASSERT_NE(noise, layers.end());
  EXPECT_EQ(noise->noise, PictureLayer::Noise::kPilot);
  // Blocks of 8 x 8 pixels, from (8, 0) on.
  wire::PilotBlocks blocks{.x0 = 1, .y0 = 0, .x1 = 3, .y1 = 1, .values = {{{1, 3}, 5}, {{0, 0}, 5}}};
  const auto pilot = std::make_shared<const wire::PilotBlocks>(blocks);
  const PixelArea area{0, 0, 24, 8};
  const wire::TileResult result = tile(area, 16, [](auto, auto, auto) { return 3; });
  Picture picture(area, 0, *noise);
  ASSERT_TRUE(picture.add(result, 0).ok());
  EXPECT_TRUE(std::isnan(scalars(picture.pixels(0, {8, 0, 9, 1}))[0])) << "it has no pilot";
  picture.set_pilot(pilot);
  ASSERT_TRUE(picture.add(result, 0).ok());
  // relMSE of 2 for one sample of light 3, by 16 samples.
  EXPECT_NEAR(scalars(picture.pixels(0, {8, 7, 9, 8}))[0], std::sqrt(2 * (9 + 0.01) / 16), 1e-5);
  EXPECT_EQ(scalars(picture.pixels(0, {16, 0, 17, 1}))[0], 0);
  EXPECT_TRUE(std::isnan(scalars(picture.pixels(0, {7, 0, 8, 1}))[0])) << "beyond the pilot's blocks";
}

TEST(Picture, CountsSamplesAndCost) {
  Picture samples({0, 0, 4, 4}, 0, layer("samples")), cost({0, 0, 4, 4}, 0, layer("cost"));
  for (Picture* picture : {&samples, &cost}) {
    ASSERT_TRUE(picture->add(tile({0, 0, 4, 4}, 16, [](auto, auto, auto) { return 0; }), 8).ok());
    ASSERT_TRUE(picture->add(tile({0, 0, 4, 4}, 16, [](auto, auto, auto) { return 0; }), 8).ok());
  }
  EXPECT_THAT(scalars(samples.pixels(1, {0, 0, 1, 1})), testing::ElementsAre(32));
  // 16 s for 16 pixels.
  EXPECT_THAT(scalars(cost.pixels(0, {3, 3, 4, 4})), testing::ElementsAre(1024));
  EXPECT_THAT(scalars(cost.pixels(2, {0, 0, 1, 1})), testing::ElementsAre(1024));
}

TEST(Picture, RemembersWhereItChanged) {
  Picture picture({0, 0, 64, 64}, 0, layer("color"));
  const auto black = [](auto, auto, auto) { return 0; };
  ASSERT_TRUE(picture.add(tile({0, 0, 8, 8}, 1, black), 0).ok());
  ASSERT_TRUE(picture.add(tile({60, 60, 68, 68}, 1, black), 0).ok());
  EXPECT_THAT(*picture.changed_since(1), testing::ElementsAre(PixelArea{60, 60, 64, 64}));
  for (std::uint32_t i = 0; i < Picture::kMostAreas; ++i)
    ASSERT_TRUE(picture.add(tile({0, 0, 1, 1}, 1, black), 0).ok());
  EXPECT_FALSE(picture.changed_since(1)) << "forgotten";
  EXPECT_FALSE(picture.changed_since(picture.changes() + 1)) << "of another picture";
}

TEST(Picture, BoundsWhatItKeeps) {
  const PixelArea large{0, 0, 65536, 65536};
  const std::uint32_t level = Picture::level_for(large);
  EXPECT_LE((std::size_t{65536} >> level) * (std::size_t{65536} >> level), Picture::kMostPixels);
  EXPECT_GT((std::size_t{65536} >> (level - 1)) * (std::size_t{65536} >> (level - 1)), Picture::kMostPixels);
  EXPECT_EQ(Picture::level_for({0, 0, 1920, 1080}), 0u);
}

TEST(Picture, RefusesResultsWithoutItsChannels) {
  Picture picture({0, 0, 4, 4}, 0, layer("depth"));
  wire::TileResult result = tile({0, 0, 4, 4}, 1, [](auto, auto, auto) { return 0; });
  result.channels.resize(3);
  EXPECT_TRUE(absl::IsInvalidArgument(picture.add(result, 0)));
}

}  // namespace
}  // namespace tessera::server
