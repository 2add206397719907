// Spaces of images, and images with bands of spectral radiance.
#include "image/spectral_image.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "image/color_space.h"
#include "image/exr.h"
#include "image/png.h"
#include "image/spectral_metrics.h"
#include "spectra/light/daylight.h"
#include "unit/client/files.h"

namespace tessera::client {
namespace {

using ::testing::HasSubstr;

Image image_of(const std::vector<std::pair<std::string, std::vector<float>>>& channels) {
  Image image;
  image.data = image.display = {0, 0, static_cast<std::int32_t>(channels.front().second.size()), 1};
  for (const auto& [name, values] : channels) image.add(name).values = values;
  return image;
}

std::string refusal(const absl::Status& status) { return std::string(status.message()); }

TEST(ColorSpace, GoesToFilesAndBack) {
  const support::TempDir directory;
  Image image = image_of({{"R", {1, 2}}, {"G", {3, 4}}, {"B", {5, 6}}});
  EXPECT_FALSE(rec709_from(image).has_value());
  set_space(spectra::kAcesCg, image);
  ASSERT_TRUE(write_exr(image, directory / "a.exr").ok());
  const Image read = *read_exr(directory / "a.exr");
  EXPECT_NEAR(space_of(read).green.y, 0.83, 1e-6);
  EXPECT_NEAR(space_of(read).white.x, 0.32168, 1e-6);
  EXPECT_TRUE(rec709_from(read).has_value());
  // Rec.709 is what a file without the attribute is in.
  set_space(spectra::kRec709, image);
  ASSERT_TRUE(write_exr(image, directory / "b.exr").ok());
  EXPECT_FALSE(read_exr(directory / "b.exr")->metadata.contains(kChromaticities));
}

TEST(ColorSpace, PrimariesThatSpanNoSpaceAreNotTaken) {
  Image image = image_of({{"R", {1}}, {"G", {1}}, {"B", {1}}});
  image.metadata[kChromaticities] = Chromaticities{};
  EXPECT_FALSE(rec709_from(image).has_value());
  const spectra::Chromaticity one = {0.3, 0.3};
  set_space({one, one, one, one}, image);
  EXPECT_FALSE(rec709_from(image).has_value());
}

TEST(ColorSpace, ConvertsPictureAndLayersWhiteOnWhite) {
  Image image = image_of({{"R", {1, 0.7f}},
                          {"G", {1, 0.2f}},
                          {"B", {1, 0.1f}},
                          {"A", {0.5f, 1}},
                          {"light.R", {0.7f, 0}},
                          {"light.G", {0.2f, 0}},
                          {"light.B", {0.1f, 0}},
                          {"variance.R", {2, 2}},
                          {"variance.G", {2, 2}},
                          {"variance.B", {2, 2}}});
  const Image before = image;
  convert_space(spectra::kRec2020, image);
  for (const char* channel : {"R", "G", "B"}) EXPECT_NEAR(image.find(channel)->values[0], 1, 1e-6);
  // BT.2087: 0.6274 0.3293 0.0433 of red.
  EXPECT_NEAR(image.find("R")->values[1], 0.6274 * 0.7 + 0.3293 * 0.2 + 0.0433 * 0.1, 1e-4);
  EXPECT_EQ(image.find("light.R")->values[0], image.find("R")->values[1]);
  for (const char* channel : {"A", "variance.R", "variance.B"})
    EXPECT_EQ(image.find(channel)->values, before.find(channel)->values);
  convert_space(spectra::kRec709, image);
  for (const Channel& channel : image.channels) {
    for (std::size_t i = 0; i < 2; ++i)
      EXPECT_NEAR(channel.values[i], before.find(channel.name)->values[i], 1e-6);
  }
}

TEST(ColorSpace, PngShowsWhatTheSpaceMeans) {
  const support::TempDir directory;
  Image plain = image_of({{"R", {0.5f, 1}}, {"G", {0.25f, 0.75f}}, {"B", {0.1f, 0.5f}}}), other = plain;
  convert_space(spectra::kAcesCg, other);
  ASSERT_GT(std::abs(other.find("R")->values[0] - 0.5f), 0.02f);
  ASSERT_TRUE(write_png(plain, directory / "plain.png").ok());
  ASSERT_TRUE(write_png(other, directory / "other.png").ok());
  EXPECT_EQ(read_bytes(directory / "plain.png"), read_bytes(directory / "other.png"));
}

TEST(SpectralImage, BandsMeetHalfWayOrAsTheFileTells) {
  Image image =
      image_of({{"S0.600,000000nm", {3}}, {"S0.400,000000nm", {1}}, {"R", {0}}, {"S0.500,0nm", {2}}});
  auto bands = bands_of(image);
  ASSERT_TRUE(bands.ok());
  ASSERT_EQ(bands->size(), 3u);
  EXPECT_EQ((*bands)[0].from_nm, 350);
  EXPECT_EQ((*bands)[0].to_nm, 450);
  EXPECT_EQ((*bands)[2].to_nm, 650);
  EXPECT_EQ((*bands)[1].channel, 3u);
  Image one = image_of({{"S0.550,000000nm", {1}}});
  EXPECT_THAT(refusal(bands_of(one).status()), HasSubstr("one band"));
  one.metadata[kFilmOfImage] = std::string("spectral:1:540-560");
  EXPECT_EQ(bands_of(one)->front().to_nm, 560);
  EXPECT_THAT(refusal(bands_of(image_of({{"R", {1}}})).status()), HasSubstr("no bands"));
}

TEST(SpectralImage, ASensorSeesTheSumOfItsBands) {
  const auto sensor =
      *spectra::sensor_response(*spectra::parse_sensor("nikon-d5100"), spectra::unit_d65(), spectra::kRec709);
  const Image image = image_of({{"S0.450,000000nm", {1, 0}},
                                {"S0.550,000000nm", {1, 2}},
                                {"S0.650,000000nm", {1, 0}},
                                {"A", {1, 0.5f}}});
  const auto seen = seen_by(image, sensor);
  ASSERT_TRUE(seen.ok());
  EXPECT_EQ(seen->channels.size(), 4u);
  EXPECT_EQ(seen->find("A")->values[1], 0.5f);
  const spectra::Triple all = spectra::seen(sensor, 400, 700), middle = spectra::seen(sensor, 500, 600);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(seen->channels[c].values[0], all[c], 1e-6 * all[c]);
    EXPECT_NEAR(seen->channels[c].values[1], 2 * middle[c], 1e-6 * middle[c]);
  }
}

TEST(SpectralMetrics, TellTheErrorOfEachBandAndOfColours) {
  const Image reference = image_of({{"S0.450,000000nm", {0.01f, 0.02f, 0.01f}},
                                    {"S0.550,000000nm", {0.01f, 0.03f, 0.01f}},
                                    {"S0.650,000000nm", {0.02f, 0.01f, 0.01f}}});
  const auto same = compare_bands(reference, reference, spectra::cie1931());
  ASSERT_TRUE(same.ok());
  EXPECT_EQ(same->bands.size(), 3u);
  EXPECT_EQ(same->mean_delta_e, 0);
  EXPECT_EQ(same->bands[1].relmse, 0);

  Image test = reference;
  for (float& value : test.channels[1].values) value *= 1.1f;
  test.channels[2].values[2] = std::numeric_limits<float>::quiet_NaN();
  const auto other = compare_bands(reference, test, spectra::cie1931());
  ASSERT_TRUE(other.ok());
  EXPECT_EQ(other->non_finite_pixels, 1u);
  EXPECT_EQ(other->bands[0].relmse, 0);
  EXPECT_NEAR(other->bands[1].bias_percent, 10, 1e-4);
  // (0.1 R)^2 / (R^2 + 0.01 m^2) of R = 0.01 and 0.03, whose mean m is 0.02.
  EXPECT_NEAR(other->bands[1].relmse, (1e-6 / (1e-4 + 4e-6) + 9e-6 / (9e-4 + 4e-6)) / 2, 1e-7);
  EXPECT_GT(other->mean_delta_e, 0.5);
  EXPECT_GE(other->most_delta_e, other->mean_delta_e);
  const auto json = nlohmann::json::parse(to_json(*other));
  EXPECT_EQ(json["bands"][1]["nm"], 550);
  EXPECT_THAT(to_text(*other), HasSubstr("CIEDE2000: mean "));

  const Image bands = image_of({{"S0.450,000000nm", {1, 1, 1}}, {"S0.550,000000nm", {1, 1, 1}}});
  EXPECT_THAT(refusal(compare_bands(reference, bands, spectra::cie1931()).status()),
              HasSubstr("bands differ"));
  const Image small =
      image_of({{"S0.450,000000nm", {1}}, {"S0.550,000000nm", {1}}, {"S0.650,000000nm", {1}}});
  EXPECT_THAT(refusal(compare_bands(reference, small, spectra::cie1931()).status()),
              HasSubstr("sizes differ"));
  EXPECT_THAT(refusal(compare_bands(reference, image_of({{"R", {1, 1, 1}}}), spectra::cie1931()).status()),
              HasSubstr("test: the image has no bands"));
}

}  // namespace
}  // namespace tessera::client
