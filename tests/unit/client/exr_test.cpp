#include "image/exr.h"
#include "support/needs.h"

#include <OpenEXR/ImfArray.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfRgbaFile.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "unit/client/files.h"

namespace tessera::client {
namespace {

using ::testing::HasSubstr;

Image random_image(Window data, Window display, const std::vector<std::string>& names) {
  Image image;
  image.data = data;
  image.display = display;
  std::mt19937 random(1);
  std::lognormal_distribution<float> value(0, 2);
  for (const std::string& name : names) {
    for (float& v : image.add(name).values) v = value(random);
  }
  return image;
}

Image small_image() { return random_image({0, 0, 7, 5}, {0, 0, 7, 5}, {"R", "G", "B"}); }

TEST(Exr, ManyPartsHaveALayerEach) {
  const support::TempDir directory;
  Image image = random_image({3, 2, 20, 13}, {0, 0, 64, 48},
                             {"R", "G", "B", "A", "samples", "light.key.R", "light.key.G", "caustics.R"});
  image.metadata["tessera.spp"] = std::int32_t{4};
  ASSERT_TRUE(write_exr(image, directory / "a.exr", {.multipart = true}).ok());
  Imf::MultiPartInputFile file((directory / "a.exr").c_str());
  const std::vector<std::vector<std::string>> wanted = {
      {"A", "B", "G", "R", "samples"}, {"caustics.R"}, {"light.key.G", "light.key.R"}};
  const char* const names[] = {"rgba", "caustics", "light.key"};
  ASSERT_EQ(file.parts(), 3);
  for (int i = 0; i < 3; ++i) {
    const Imf::Header& header = file.header(i);
    EXPECT_EQ(header.name(), names[i]);
    std::vector<std::string> channels;
    for (auto it = header.channels().begin(); it != header.channels().end(); ++it)
      channels.push_back(it.name());
    EXPECT_EQ(channels, wanted[static_cast<std::size_t>(i)]);
    std::vector<float> values(image.pixel_count());
    Imf::FrameBuffer frame;
    frame.insert(channels[0], Imf::Slice::Make(Imf::FLOAT, values.data(), header.dataWindow()));
    Imf::InputPart part(file, i);
    part.setFrameBuffer(frame);
    part.readPixels(2, 12);
    EXPECT_EQ(values, image.find(channels[0])->values);
  }
  const absl::StatusOr<Image> read = read_exr(directory / "a.exr");
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->channels.size(), 8u);
  for (const Channel& channel : image.channels)
    EXPECT_EQ(read->find(channel.name)->values, channel.values) << channel.name;
  // A picture without layers has nothing to divide.
  ASSERT_TRUE(write_exr(small_image(), directory / "b.exr", {.multipart = true}).ok());
  EXPECT_EQ(Imf::MultiPartInputFile((directory / "b.exr").c_str()).parts(), 1);
}

/// Bits without any order, no block of which can be packed.
Image image_of_noise(std::int32_t width, std::int32_t height) {
  Image image;
  image.data = image.display = {0, 0, width, height};
  std::mt19937 random(2);
  for (const char* const name : {"R", "G", "B"}) {
    for (float& v : image.add(name).values) v = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
  }
  return image;
}

TEST(Exr, BlocksThatDoNotShrinkAndSinglePixelsAreReadAsWritten) {
  const support::TempDir directory;
  for (const auto& [width, height] : {std::pair{33, 50}, {1, 17}, {1, 1}}) {
    const Image image = image_of_noise(width, height);
    ASSERT_TRUE(write_exr(image, directory / "a.exr").ok());
    Imf::InputFile file((directory / "a.exr").c_str());
    std::vector<float> values(image.pixel_count());
    Imf::FrameBuffer frame;
    frame.insert("G", Imf::Slice::Make(Imf::FLOAT, values.data(), file.header().dataWindow()));
    file.setFrameBuffer(frame);
    file.readPixels(0, height - 1);
    // Bit by bit: some are no numbers.
    EXPECT_EQ(std::memcmp(values.data(), image.find("G")->values.data(), values.size() * sizeof(float)), 0);
  }
}

TEST(Exr, LongNamesAreKept) {
  const support::TempDir directory;
  const std::string name = "variance.a-light-with-a-name-of-more-than-31-bytes.R";
  Image image = random_image({0, 0, 7, 5}, {0, 0, 7, 5}, {"R", name});
  const std::string key = "tessera.an-attribute-with-a-name-of-more-than-31-bytes";
  image.metadata[key] = std::string("");
  ASSERT_TRUE(write_exr(image, directory / "a.exr").ok());
  const absl::StatusOr<Image> read = read_exr(directory / "a.exr");
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->find(name)->values, image.find(name)->values);
  EXPECT_EQ(read->metadata.at(key), image.metadata.at(key));
  // The image that was read is written again, with the library's own facts of the file.
  ASSERT_TRUE(write_exr(*read, directory / "b.exr", {.multipart = true}).ok());
  const absl::StatusOr<Image> again = read_exr(directory / "b.exr");
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->metadata.at(key), image.metadata.at(key));
}

TEST(Exr, AFullDiskIsAnErrorWithItsCause) {
  const absl::Status status = write_exr(small_image(), "/dev/full");
  EXPECT_EQ(status.code(), absl::StatusCode::kInternal);
  EXPECT_THAT(std::string(status.message()), HasSubstr("/dev/full"));
  EXPECT_THAT(std::string(status.message()), HasSubstr("No space left"));
}

TEST(Exr, RoundTripIsExactInFloat) {
  const support::TempDir directory;
  Image image =
      random_image({3, 2, 20, 13}, {0, 0, 64, 48},
                   {"R", "G", "B", "A", "variance.R", "albedo.G", "normal.X", "depth.Z", "samples"});
  image.channels[0].values[4] = std::numeric_limits<float>::denorm_min();
  image.channels[0].values[5] = -std::numeric_limits<float>::max();
  set_render_info({"ab12",
                   64,
                   ~std::uint64_t{0},
                   "path",
                   "unbiased",
                   "",
                   "sobol",
                   "avx2",
                   {"avx2/embree-3.13.5/d44a0401"},
                   "0.1.0",
                   1.5},
                  image);
  ASSERT_TRUE(write_exr(image, directory / "a.exr").ok());
  const absl::StatusOr<Image> read = read_exr(directory / "a.exr");
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->data, image.data);
  EXPECT_EQ(read->display, image.display);
  ASSERT_EQ(read->channels.size(), image.channels.size());
  for (const Channel& channel : image.channels) {
    const Channel* other = read->find(channel.name);
    ASSERT_NE(other, nullptr) << channel.name;
    EXPECT_EQ(other->values, channel.values) << channel.name;
  }
  for (const auto& [name, value] : image.metadata) EXPECT_EQ(read->metadata.at(name), value) << name;
  EXPECT_EQ(std::get<std::string>(read->metadata.at("tessera.seed")), "18446744073709551615");
  EXPECT_EQ(std::get<std::int32_t>(read->metadata.at("tessera.spp")), 64);
  EXPECT_EQ(std::get<float>(read->metadata.at("tessera.render_seconds")), 1.5f);
}

TEST(Exr, HalfKeepsCountsAndClampsWhatIsTooLarge) {
  const support::TempDir directory;
  Image image = random_image({0, 0, 16, 16}, {0, 0, 16, 16}, {"R", "G", "B", "depth.Z", "samples"});
  image.channels[0].values[0] = 1e9f;
  image.channels[3].values[0] = 123456.7f;
  image.channels[4].values[0] = 1000001;
  ASSERT_TRUE(write_exr(image, directory / "a.exr", {.half = true}).ok());
  const absl::StatusOr<Image> read = read_exr(directory / "a.exr");
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->find("R")->values[0], 65504);
  EXPECT_EQ(read->find("depth.Z")->values, image.channels[3].values);
  EXPECT_EQ(read->find("samples")->values, image.channels[4].values);
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    // A half has 11 significant bits, so rounding errs by at most 2^-11 of the value; values here are normal
    // halves.
    const float g = image.channels[1].values[i];
    EXPECT_NEAR(read->find("G")->values[i], g, std::ldexp(g, -11));
  }
}

TEST(Exr, ReadsTiledHalfFiles) {
  const support::TempDir directory;
  const int width = 33, height = 21;
  Imf::Header header(width, height);
  header.channels().insert("Y", Imf::Channel(Imf::HALF));
  header.setTileDescription(Imf::TileDescription(16, 16, Imf::MIPMAP_LEVELS));
  Imf::Array2D<Imath::half> pixels(height, width);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) pixels[y][x] = static_cast<float>(x + 64 * y);  // exact: at most 11 bits
  }
  {
    Imf::FrameBuffer frame;
    frame.insert("Y", Imf::Slice(Imf::HALF, reinterpret_cast<char*>(&pixels[0][0]), 2, 2 * width));
    Imf::TiledOutputFile file((directory / "a.exr").c_str(), header);
    file.setFrameBuffer(frame);
    for (int level = 0; level < file.numLevels(); ++level) {
      file.writeTiles(0, file.numXTiles(level) - 1, 0, file.numYTiles(level) - 1, level);
    }
  }
  const absl::StatusOr<Image> read = read_exr(directory / "a.exr");
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_NE(read->find("Y"), nullptr);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      ASSERT_EQ(read->find("Y")->values[std::size_t(y * width + x)], static_cast<float>(x + 64 * y));
    }
  }
  const RgbPlanes rgb = rgb_planes(*read);
  EXPECT_EQ(rgb.r, read->find("Y")->values.data());
  EXPECT_EQ(rgb.b, rgb.r);
}

TEST(Exr, ReadsLuminanceChromaFiles) {
  const support::TempDir directory;
  const int width = 32, height = 32;
  const Imf::Array2D<Imf::Rgba> pixels(height, width);
  Imf::Array2D<Imf::Rgba> orange(height, width);
  for (int i = 0; i < width * height; ++i) orange[0][i] = Imf::Rgba(0.75f, 0.5f, 0.25f, 1);
  {
    Imf::RgbaOutputFile file((directory / "a.exr").c_str(), width, height, Imf::WRITE_YC);
    file.setFrameBuffer(&orange[0][0], 1, width);
    file.writePixels(height);
  }
  const absl::StatusOr<Image> read = read_exr(directory / "a.exr");
  ASSERT_TRUE(read.ok()) << read.status();
  const RgbPlanes rgb = rgb_planes(*read);
  // OpenEXR rounds luminance to 7 bits and chroma to 5 bits of mantissa before it writes them: 2^-6 relative
  // at most.
  EXPECT_NEAR(rgb.r[500], 0.75f, 0.75f / 64);
  EXPECT_NEAR(rgb.g[500], 0.5f, 0.5f / 64);
  EXPECT_NEAR(rgb.b[500], 0.25f, 0.25f / 32);
}

TEST(Exr, ReadsTheFirstOfSeveralParts) {
  const support::TempDir directory;
  std::vector<Imf::Header> headers;
  for (const char* name : {"left", "right"}) {
    Imf::Header header(4, 4);
    header.setName(name);
    header.setType(Imf::SCANLINEIMAGE);
    header.channels().insert("R", Imf::Channel(Imf::FLOAT));
    headers.push_back(header);
  }
  {
    Imf::MultiPartOutputFile file((directory / "a.exr").c_str(), headers.data(), 2);
    for (int part = 0; part < 2; ++part) {
      std::vector<float> values(16, static_cast<float>(part + 1));
      Imf::FrameBuffer frame;
      frame.insert("R", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()), 4, 16));
      Imf::OutputPart output(file, part);
      output.setFrameBuffer(frame);
      output.writePixels(4);
    }
  }
  const absl::StatusOr<Image> read = read_exr(directory / "a.exr");
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->find("R")->values, std::vector<float>(16, 1.0f));
}

TEST(Exr, ReadsImagesOfOthers) {
  const std::string path = "../shared/scenes/pbrt/cornell-box/reference.exr";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << test::needs(path);
  const absl::StatusOr<Image> read = read_exr(path);
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_NE(read->find("R"), nullptr);
  // The mean of red as NumPy gives it for what OpenImageIO reads, to seven digits.
  double sum = 0;
  for (float v : read->find("R")->values) sum += v;
  EXPECT_NEAR(sum / static_cast<double>(read->pixel_count()), 0.1962514, 5e-8);
}

TEST(Exr, ErrorsNameTheFile) {
  const support::TempDir directory;
  EXPECT_EQ(read_exr(directory / "none.exr").status(),
            absl::NotFoundError((directory / "none.exr") + ": no such file"));
  write_bytes(directory / "text.exr", "not an image at all, but long enough to look like one");
  const absl::Status text = read_exr(directory / "text.exr").status();
  EXPECT_EQ(text.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(text.message()), HasSubstr(directory / "text.exr"));
  EXPECT_EQ(read_exr(directory / "").status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(write_exr(small_image(), directory / "no/such/place.exr").code(), absl::StatusCode::kNotFound);
}

TEST(Exr, RefusesImagesThatDoNotFitTogether) {
  const support::TempDir directory;
  const auto refused = [&](const Image& image) {
    return write_exr(image, directory / "a.exr").code() == absl::StatusCode::kInvalidArgument;
  };
  Image image = small_image();
  image.channels[1].values.pop_back();
  EXPECT_TRUE(refused(image));
  image = small_image();
  image.channels[1].name = "R";
  EXPECT_TRUE(refused(image));
  image = small_image();
  image.channels.clear();
  EXPECT_TRUE(refused(image));
  EXPECT_TRUE(refused(Image{}));
  EXPECT_EQ(file_count(directory), 0u);
}

TEST(Exr, RefusesMorePixelsThanTheLimit) {
  const support::TempDir directory;
  ASSERT_TRUE(write_exr(small_image(), directory / "a.exr").ok());
  EXPECT_TRUE(read_exr(directory / "a.exr", 35).ok());
  const absl::Status status = read_exr(directory / "a.exr", 34).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("7 x 5"));
}

// Every truncation and every damaged byte gives an image or an error, never a crash or a huge allocation.
TEST(Exr, SurvivesDamagedFiles) {
  const support::TempDir directory;
  Image image = small_image();
  set_render_info(
      {"ab12", 64, 7, "path", "unbiased", "", "sobol", "avx2", {"avx2/embree-3.13.5/d44a0401"}, "0.1.0", 1.5},
      image);
  ASSERT_TRUE(write_exr(image, directory / "good.exr").ok());
  const std::string good = read_bytes(directory / "good.exr");
  const std::string path = directory / "bad.exr";

  for (std::size_t length = 0; length < good.size(); ++length) {
    write_bytes(path, good.substr(0, length));
    EXPECT_FALSE(read_exr(path).ok()) << "cut to " << length << " bytes";
  }
  std::mt19937 random(2);
  std::size_t refused = 0;
  for (std::size_t i = 0; i < good.size(); ++i) {
    for (const char mask : {char(0x01), char(0x80), char(0xff)}) {
      std::string bad = good;
      bad[i] = static_cast<char>(bad[i] ^ mask);
      write_bytes(path, bad);
      if (!read_exr(path).ok()) ++refused;
    }
  }
  // Most of the header matters, so plenty of these must be noticed; metadata and pixels may change unnoticed.
  EXPECT_GT(refused, good.size() / 4);
}

}  // namespace
}  // namespace tessera::client
