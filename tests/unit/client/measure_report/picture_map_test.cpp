#include "plot/picture_map.h"

#include <gtest/gtest.h>

#include "image/color_space.h"

namespace tessera::client {
namespace {

Image picture_of(std::vector<std::pair<std::string, std::vector<float>>> channels) {
  Image image;
  image.data = image.display = {0, 0, 2, 1};
  for (auto& [name, values] : channels) image.add(name).values = std::move(values);
  return image;
}

// Weights of red, green and blue as the standards print them, with four decimals.
TEST(PictureMap, LuminanceIsThatOfThePicturesSpace) {
  Image image = picture_of({{"R", {1, 2}}, {"G", {0, 3}}, {"B", {0, 4}}});
  const auto rec709 = luminance_grid(image, 100);
  ASSERT_TRUE(rec709.ok());
  EXPECT_NEAR(rec709->values[0], 21.26, 100 * 5e-5);
  EXPECT_NEAR(rec709->values[1], 100 * (2 * 0.2126 + 3 * 0.7152 + 4 * 0.0722), 100 * 9 * 5e-5);
  set_space(spectra::kRec2020, image);
  EXPECT_NEAR(luminance_grid(image, 100)->values[0], 26.27, 100 * 5e-5);
  const auto grey = luminance_grid(picture_of({{"Y", {0.25, 8}}}), 2);
  EXPECT_NEAR(grey->values[1], 16, 16e-6);
}

TEST(PictureMap, ASensorsOwnChannelsTellNoLuminance) {
  Image image = picture_of({{"R", {1, 2}}, {"G", {0, 3}}, {"B", {0, 4}}});
  image.metadata[kRawChannels] = std::string("nikon-d5100");
  EXPECT_TRUE(absl::IsFailedPrecondition(luminance_grid(image, 1).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(luminance_grid(Image(), 1).status()));
}

TEST(PictureMap, PixelsOfOneAreAsBrightAsTheFileSays) {
  Image image = picture_of({{"Y", {1, 1}}});
  EXPECT_EQ(white_luminance(image, {}), 683);
  image.metadata["whiteLuminance"] = 120.f;
  EXPECT_EQ(white_luminance(image, {}), 120);
  EXPECT_EQ(white_luminance(image, 5), 5);
  image.metadata["whiteLuminance"] = std::string("bright");
  EXPECT_EQ(white_luminance(image, {}), 683);
}

}  // namespace
}  // namespace tessera::client
