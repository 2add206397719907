#include "image/png.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <limits>
#include <set>
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

/// Red, green and blue of all pixels.
std::vector<unsigned char> read_png(const std::string& path) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  EXPECT_TRUE(png_image_begin_read_from_file(&png, path.c_str()));
  png.format = PNG_FORMAT_RGB;
  std::vector<unsigned char> bytes(PNG_IMAGE_SIZE(png));
  EXPECT_TRUE(png_image_finish_read(&png, nullptr, bytes.data(), 0, nullptr));
  return bytes;
}

TEST(Png, WritesRowsFromTheTop) {
  const support::TempDir directory;
  Image image;
  image.data = image.display = {0, 0, 3, 2};
  image.add("R").values = {1, 0, 0, 0.5f, 0, 0};
  image.add("G").values = {0, 1, 0, 0.5f, 0, 2};
  image.add("B").values = {0, 0, 1, 0.5f, 0, -1};
  ASSERT_TRUE(write_png(image, directory / "a.png").ok());

  EXPECT_EQ(read_png(directory / "a.png"),
            (std::vector<unsigned char>{255, 0, 0, 0, 255, 0, 0, 0, 255, 188, 188, 188, 0, 0, 0, 0, 255, 0}));
}

Image grey_image(std::int32_t side, float value) {
  Image image;
  image.data = image.display = {0, 0, side, side};
  for (const char* name : {"R", "G", "B"})
    image.add(name).values.assign(static_cast<std::size_t>(side * side), value);
  return image;
}

TEST(Png, ExposureIsInStops) {
  const support::TempDir directory;
  ASSERT_TRUE(write_png(grey_image(1, 0.09f), directory / "a.png", {.exposure_stops = 1}).ok());
  EXPECT_EQ(read_png(directory / "a.png")[0], srgb_byte(0.18f));
}

TEST(Png, DitheringKeepsTheMeanOfAnArea) {
  const support::TempDir directory;
  constexpr std::int32_t kSide = 64;
  for (const float value : {0.0f, 0.01f, 0.1803f, 0.5f, 1.0f}) {
    const Image image = grey_image(kSide, value);
    ASSERT_TRUE(write_png(image, directory / "a.png", {.dithers = true}).ok());
    const std::vector<unsigned char> bytes = read_png(directory / "a.png");
    // Of the whole image and of each block of 8x8: a code apart at most, and near the code that 8 bits lack.
    for (const std::int32_t block : {kSide, 8}) {
      for (std::int32_t y = 0; y < kSide; y += block) {
        for (std::int32_t x = 0; x < kSide; x += block) {
          for (std::int32_t c = 0; c < 3; ++c) {
            double sum = 0;
            for (std::int32_t i = 0; i < block * block; ++i) {
              const std::int32_t pixel = (y + i / block) * kSide + x + i % block;
              sum += bytes[static_cast<std::size_t>(3 * pixel + c)];
            }
            EXPECT_NEAR(sum / (block * block), 255 * srgb_encoded(value), block == kSide ? 0.005 : 0.06)
                << value;
          }
        }
      }
    }
  }
}

/// Rows that are made when they are asked for, and tell what was asked.
class AskedRows final : public Rows {
 public:
  absl::Status read(std::size_t plane, std::int32_t y, std::span<float> row) override {
    if (y == failing_row) return absl::InternalError("the disk is gone");
    for (std::size_t x = 0; x < row.size(); ++x) row[x] = value(plane, y, x);
    planes.insert(plane);
    return absl::OkStatus();
  }
  static float value(std::size_t plane, std::int32_t y, std::size_t x) {
    return static_cast<float>((plane * 31 + static_cast<std::size_t>(y) * 7 + x) % 100) / 99;
  }
  std::int32_t failing_row = -1;
  std::set<std::size_t> planes;
};

TEST(Png, RowsNeedNotBeInMemory) {
  const support::TempDir directory;
  Image image;
  image.data = image.display = {0, 0, 50, 40};
  for (const char* name : {"variance.R", "A", "B", "G", "R"}) image.channels.push_back({name, {}});
  AskedRows rows;
  ASSERT_TRUE(write_png(image, rows, directory / "rows.png").ok());
  EXPECT_EQ(rows.planes, (std::set<std::size_t>{2, 3, 4})) << "no other plane is looked at";
  for (std::size_t plane = 0; plane < image.channels.size(); ++plane) {
    for (std::int32_t y = 0; y < 40; ++y) {
      for (std::size_t x = 0; x < 50; ++x)
        image.channels[plane].values.push_back(AskedRows::value(plane, y, x));
    }
  }
  ASSERT_TRUE(write_png(image, directory / "whole.png").ok());
  EXPECT_EQ(read_bytes(directory / "rows.png"), read_bytes(directory / "whole.png"));

  rows.failing_row = 20;
  EXPECT_EQ(write_png(image, rows, directory / "b.png").message(), "the disk is gone");
  EXPECT_FALSE(std::filesystem::exists(directory / "b.png"));
}

TEST(Png, SaysWhenTheDiskIsFull) {
  Image image;
  image.data = image.display = {0, 0, 500, 400};
  for (const char* name : {"R", "G", "B"}) image.add(name);
  EXPECT_THAT(std::string(write_png(image, "/dev/full").message()), testing::HasSubstr("cannot write"));
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
