#include "image/png.h"

#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <limits>
#include <vector>

#include "unit/client/files.h"

namespace tessera::client {
namespace {

TEST(Png, SrgbBytesFollowTheStandard) {
  EXPECT_EQ(srgb_byte(0), 0);
  EXPECT_EQ(srgb_byte(1), 255);
  // IEC 61966-2-1: 1.055 * 0.5^(1/2.4) - 0.055 = 0.73536, times 255 = 187.5 -> 188; 0.18 -> 0.46135 -> 117.6.
  EXPECT_EQ(srgb_byte(0.5f), 188);
  EXPECT_EQ(srgb_byte(0.18f), 118);
  EXPECT_EQ(srgb_byte(0.002f), 7);  // 12.92 * 0.002 * 255 = 6.59
  EXPECT_EQ(srgb_byte(-1), 0);
  EXPECT_EQ(srgb_byte(1e30f), 255);
  EXPECT_EQ(srgb_byte(std::numeric_limits<float>::infinity()), 255);
  EXPECT_EQ(srgb_byte(std::numeric_limits<float>::quiet_NaN()), 0);
}

TEST(Png, SrgbBytesDecodeToTheNearestCode) {
  for (int code = 0; code < 256; ++code) {
    const double encoded = code / 255.0;
    const double linear = encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
    EXPECT_EQ(srgb_byte(static_cast<float>(linear)), code);
  }
}

TEST(Png, WritesRowsFromTheTop) {
  const support::TempDir directory;
  Image image;
  image.data = image.display = {0, 0, 3, 2};
  image.add("R").values = {1, 0, 0, 0.5f, 0, 0};
  image.add("G").values = {0, 1, 0, 0.5f, 0, 2};
  image.add("B").values = {0, 0, 1, 0.5f, 0, -1};
  ASSERT_TRUE(write_png(image, directory / "a.png").ok());

  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  ASSERT_TRUE(png_image_begin_read_from_file(&png, (directory / "a.png").c_str()));
  png.format = PNG_FORMAT_RGB;
  ASSERT_EQ(png.width, 3u);
  ASSERT_EQ(png.height, 2u);
  std::vector<unsigned char> bytes(PNG_IMAGE_SIZE(png));
  ASSERT_TRUE(png_image_finish_read(&png, nullptr, bytes.data(), 0, nullptr));
  EXPECT_EQ(bytes,
            (std::vector<unsigned char>{255, 0, 0, 0, 255, 0, 0, 0, 255, 188, 188, 188, 0, 0, 0, 0, 255, 0}));
}

TEST(Png, ErrorsNameTheFile) {
  const support::TempDir directory;
  Image image;
  EXPECT_EQ(write_png(image, directory / "a.png").code(), absl::StatusCode::kInvalidArgument);
  image.data = image.display = {0, 0, 1, 1};
  image.add("Y");
  const absl::Status status = write_png(image, directory / "no/a.png");
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_TRUE(std::string(status.message()).starts_with(directory / "no/a.png")) << status;
}

}  // namespace
}  // namespace tessera::client
