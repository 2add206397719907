// Files are written with OpenImageIO into a directory of their own, and read back from memory.
#include "render/color/texture_load.h"

#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>

namespace tessera::render {
namespace {

using testing::HasSubstr;

class TextureLoad : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "tessera-texture-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    directory_ = pattern;
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }

  /// The bytes of a file with the given pixels, rows from the top.
  template <class T>
  std::string file(const std::string& name, int width, int height, int channels, OIIO::TypeDesc type,
                   const std::vector<T>& pixels) {
    const std::string path = (directory_ / name).string();
    auto output = OIIO::ImageOutput::create(path);
    if (!output) return {};
    OIIO::ImageSpec spec(width, height, channels, type);
    spec.attribute("oiio:UnassociatedAlpha", 1);
    const auto from = sizeof(T) == 1   ? OIIO::TypeDesc::UINT8
                      : sizeof(T) == 2 ? OIIO::TypeDesc::UINT16
                                       : OIIO::TypeDesc::FLOAT;
    EXPECT_TRUE(output->open(path, spec) && output->write_image(from, pixels.data()) && output->close())
        << name << output->geterror();
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  std::filesystem::path directory_;
};

/// A PFM file of RGB pixels, which come with rows from the top: the format has them from the bottom.
std::string pfm(int width, int height, const std::vector<float>& pixels) {
  std::string bytes = "PF\n" + std::to_string(width) + " " + std::to_string(height) + "\n-1.0\n";
  const auto row = static_cast<std::size_t>(width * 3);
  for (int y = height - 1; y >= 0; --y) {
    bytes.append(reinterpret_cast<const char*>(&pixels[static_cast<std::size_t>(y) * row]),
                 row * sizeof(float));
  }
  return bytes;
}

float channel8(const TextureImage& image, std::size_t texel, int c) {
  return image.decode[image.texels8[texel] >> (8 * c) & 255];
}

// Two rows of three: red, green, blue above; black, grey, white below.
const std::vector<std::uint8_t> kFlag = {255, 0, 0, 0,   255, 0,   0,   0,   255,
                                         0,   0, 0, 128, 128, 128, 255, 255, 255};

void expect_flag(const TextureImage& image) {
  ASSERT_EQ(image.width, 3);
  ASSERT_EQ(image.height, 2);
  ASSERT_EQ(image.texels8.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_EQ(image.texels8[i] >> (8 * c) & 255, kFlag[i * 3 + c]) << i << " " << c;
    EXPECT_EQ(image.texels8[i] >> 24, 255u);
  }
}

TEST_F(TextureLoad, ReadsByteFormatsTopRowFirst) {
  for (const char* name : {"flag.png", "flag.tga", "flag.tif", "flag.bmp", "flag.ppm"}) {
    SCOPED_TRACE(name);
    const auto image = load_texture_image(file(name, 3, 2, 3, OIIO::TypeDesc::UINT8, kFlag), name);
    ASSERT_TRUE(image.ok()) << image.status();
    expect_flag(*image);
    EXPECT_EQ(image->format, TexelFormat::kSrgb8);
    EXPECT_NEAR(channel8(*image, 4, 0), 0.21586, 1e-5);  // sRGB 128
  }
}

TEST_F(TextureLoad, ReadsJpeg) {
  // Constant blocks of 16 x 16 survive the compression to a few levels.
  std::vector<std::uint8_t> pixels(32 * 32 * 3);
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x) pixels[static_cast<std::size_t>((y * 32 + x) * 3 + (y < 16 ? 0 : 2))] = 200;
  }
  const auto image =
      load_texture_image(file("blocks.jpg", 32, 32, 3, OIIO::TypeDesc::UINT8, pixels), "blocks.jpg");
  ASSERT_TRUE(image.ok()) << image.status();
  EXPECT_NEAR(image->texels8[5 * 32 + 5] & 255, 200, 12);
  EXPECT_NEAR(image->texels8[25 * 32 + 5] & 255, 0, 12);
  EXPECT_NEAR(image->texels8[25 * 32 + 5] >> 16 & 255, 200, 12);
}

TEST_F(TextureLoad, ReadsFloatFormatsTopRowFirst) {
  // Powers of two within the precision of all formats; values above 1 stay.
  const std::vector<float> pixels = {0.5f, 1, 2, 4, 8, 16, 0.25f, 0.5f, 1, 1, 1, 1};
  for (const char* name : {"f.exr", "f.hdr", "f.pfm", "f.tif"}) {
    SCOPED_TRACE(name);
    const std::string bytes =
        std::string(name) == "f.pfm" ? pfm(2, 2, pixels) : file(name, 2, 2, 3, OIIO::TypeDesc::FLOAT, pixels);
    const auto image = load_texture_image(bytes, name, {TexelEncoding::kSrgb});
    ASSERT_TRUE(image.ok()) << image.status();
    ASSERT_EQ(image->format, TexelFormat::kFloat);
    ASSERT_EQ(image->texels32.size(), 16u);
    for (std::size_t i = 0; i < 4; ++i) {
      // RGBE has a common exponent: 2^-8 of the largest channel.
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(image->texels32[i * 4 + c], pixels[i * 3 + c], pixels[i * 3 + 2] / 256) << i << c;
      EXPECT_EQ(image->texels32[i * 4 + 3], 1);
    }
  }
}

TEST_F(TextureLoad, ReadsSixteenBitsAsFloats) {
  const std::vector<std::uint16_t> pixels = {0, 32768, 65535, 1000, 2000, 3000};
  const std::string bytes = file("deep.png", 2, 1, 3, OIIO::TypeDesc::UINT16, pixels);
  const auto linear = load_texture_image(bytes, "deep.png");
  ASSERT_TRUE(linear.ok()) << linear.status();
  EXPECT_NEAR(linear->texels32[1], 32768 / 65535.0, 1e-6);
  const auto srgb = load_texture_image(bytes, "deep.png", {TexelEncoding::kSrgb});
  EXPECT_NEAR(srgb->texels32[1], std::pow((32768 / 65535.0 + 0.055) / 1.055, 2.4), 1e-6);
  const auto gamma = load_texture_image(bytes, "deep.png", {TexelEncoding::kGamma, 2.0f});
  EXPECT_NEAR(gamma->texels32[1], std::pow(32768 / 65535.0, 2), 1e-6);
}

TEST_F(TextureLoad, AppliesEncodings) {
  const std::string bytes = file("flag.png", 3, 2, 3, OIIO::TypeDesc::UINT8, kFlag);
  const auto linear = load_texture_image(bytes, "flag.png", {TexelEncoding::kLinear});
  EXPECT_EQ(linear->format, TexelFormat::kLinear8);
  EXPECT_FLOAT_EQ(channel8(*linear, 4, 1), 128 / 255.0f);
  const auto gamma = load_texture_image(bytes, "flag.png", {TexelEncoding::kGamma, 2.0f});
  EXPECT_FLOAT_EQ(channel8(*gamma, 4, 1), 128 / 255.0f * 128 / 255.0f);
}

TEST_F(TextureLoad, SpreadsGreyAndKeepsAlpha) {
  const std::vector<std::uint8_t> grey = {10, 200}, grey_alpha = {10, 100, 200, 50},
                                  rgba = {10, 20, 30, 0, 40, 50, 60, 128};
  const auto one = load_texture_image(file("1.png", 2, 1, 1, OIIO::TypeDesc::UINT8, grey), "1.png");
  ASSERT_TRUE(one.ok()) << one.status();
  EXPECT_EQ(one->texels8[1], 200u | 200u << 8 | 200u << 16 | 255u << 24);
  const auto two = load_texture_image(file("2.png", 2, 1, 2, OIIO::TypeDesc::UINT8, grey_alpha), "2.png");
  ASSERT_TRUE(two.ok()) << two.status();
  EXPECT_EQ(two->texels8[0], 10u | 10u << 8 | 10u << 16 | 100u << 24);
  // Colours are not multiplied by alpha, not even by zero.
  for (const char* name : {"4.png", "4.tga", "4.tif"}) {
    SCOPED_TRACE(name);
    const auto four = load_texture_image(file(name, 2, 1, 4, OIIO::TypeDesc::UINT8, rgba), name);
    ASSERT_TRUE(four.ok()) << four.status();
    EXPECT_EQ(four->texels8[0], 10u | 20u << 8 | 30u << 16);
    EXPECT_EQ(four->texels8[1], 40u | 50u << 8 | 60u << 16 | 128u << 24);
  }
}

TEST_F(TextureLoad, ReplacesWhatIsNotANumber) {
  const std::vector<float> pixels = {std::nanf(""), INFINITY, 3, 1, -2, 5};
  const auto image = load_texture_image(file("n.exr", 2, 1, 3, OIIO::TypeDesc::FLOAT, pixels), "n.exr");
  ASSERT_TRUE(image.ok()) << image.status();
  EXPECT_EQ(image->texels32[0], 0);
  EXPECT_EQ(image->texels32[1], 0);
  EXPECT_EQ(image->texels32[2], 3);
  EXPECT_EQ(image->texels32[5], -2);
}

TEST_F(TextureLoad, RefusesByName) {
  const auto unknown = load_texture_image("hello, world", "notes.txt").status();
  EXPECT_EQ(unknown.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(unknown.message()), HasSubstr("notes.txt"));
  EXPECT_FALSE(load_texture_image("", "nothing.png").ok());

  TextureLoadOptions small;
  small.max_texels = 5;
  const auto large =
      load_texture_image(file("flag.png", 3, 2, 3, OIIO::TypeDesc::UINT8, kFlag), "flag.png", small).status();
  EXPECT_EQ(large.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(large.message()), HasSubstr("flag.png"));
}

TEST_F(TextureLoad, SurvivesDamage) {
  // Every truncation of small files, and flipped bytes: an error or an image, never a crash.
  const std::vector<float> floats = {0.5f, 1, 2, 4, 8, 16, 0.25f, 0.5f, 1, 1, 1, 1};
  std::mt19937 random(1);
  int failures = 0;
  for (const char* name : {"d.png", "d.tga", "d.tif", "d.bmp", "d.ppm", "d.jpg", "d.exr", "d.hdr", "d.pfm"}) {
    SCOPED_TRACE(name);
    const std::string extension = std::string(name).substr(2);
    const std::string bytes = extension == "pfm" ? pfm(2, 2, floats)
                              : extension == "exr" || extension == "hdr"
                                  ? file(name, 2, 2, 3, OIIO::TypeDesc::FLOAT, floats)
                                  : file(name, 3, 2, 3, OIIO::TypeDesc::UINT8, kFlag);
    ASSERT_FALSE(bytes.empty());
    for (int i = 0; i < 60; ++i) {
      const std::string cut = bytes.substr(0, bytes.size() * static_cast<std::size_t>(i) / 60);
      failures += !load_texture_image(cut, name).ok();
      std::string flipped = bytes;
      flipped[random() % flipped.size()] = static_cast<char>(random());
      const auto image = load_texture_image(flipped, name, {TexelEncoding::kAuto, 1, 1 << 20});
      if (image.ok()) {
        const auto texels = static_cast<std::size_t>(image->width) * static_cast<std::size_t>(image->height);
        EXPECT_EQ(image->texels8.size() + image->texels32.size() / 4, texels);
      }
    }
  }
  EXPECT_GT(failures, 300);
}

TEST(TextureTable, AttributesOfManyShapesHaveSlotsBeyond32Bits) {
  TextureTable table;
  table.attribute_names = 1'000;
  EXPECT_EQ(table.attribute_slot(3'000'000, 999), 3'000'000'999u);
}

}  // namespace
}  // namespace tessera::render
