// The forms of a file for compositors: compressions, tiles, names, kinds of numbers; read by OpenEXR's
// own readers.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfTiledInputFile.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "image/exr.h"
#include "image/exr/channel_names.h"
#include "image/exr/rows.h"
#include "unit/client/files.h"

namespace tessera::client::exr_format {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Image picture(std::int32_t width, std::int32_t height, const std::vector<std::string>& names) {
  Image image;
  image.data = {3, 2, 3 + width, 2 + height};
  image.display = {0, 0, width + 10, height + 10};
  std::mt19937 random(1);
  std::lognormal_distribution<float> value(0, 1);
  for (const std::string& name : names) {
    for (float& v : image.add(name).values) v = value(random);
  }
  return image;
}

TEST(ExrFormat, EveryCompressionIsReadAsItWasWritten) {
  const support::TempDir directory;
  const Image image = picture(61, 70, {"R", "G", "B", "A", "depth.Z"});
  for (const std::uint32_t tile : {0u, 32u}) {
    for (const auto compression : {ExrCompression::kNone, ExrCompression::kRle, ExrCompression::kZips,
                                   ExrCompression::kZip, ExrCompression::kPiz}) {
      SCOPED_TRACE(static_cast<int>(compression));
      ASSERT_TRUE(
          write_exr(image, directory / "a.exr", {.compression = compression, .tile_size = tile}).ok());
      const absl::StatusOr<Image> read = read_exr(directory / "a.exr");
      ASSERT_TRUE(read.ok()) << read.status();
      EXPECT_EQ(read->data, image.data);
      for (const Channel& channel : image.channels)
        EXPECT_EQ(read->find(channel.name)->values, channel.values) << channel.name;
    }
    for (const auto compression : {ExrCompression::kDwaa, ExrCompression::kDwab}) {
      SCOPED_TRACE(static_cast<int>(compression));
      const absl::Status written =
          write_exr(image, directory / "a.exr", {.compression = compression, .tile_size = tile});
      ASSERT_TRUE(written.ok()) << written;
      const absl::StatusOr<Image> read = read_exr(directory / "a.exr");
      ASSERT_TRUE(read.ok()) << read.status();
      // Colours are quantized, all else is kept.
      EXPECT_EQ(read->find("depth.Z")->values, image.find("depth.Z")->values);
      double difference = 0, sum = 0;
      for (std::size_t i = 0; i < image.pixel_count(); ++i) {
        difference += std::abs(double{read->find("G")->values[i]} - double{image.find("G")->values[i]});
        sum += image.find("G")->values[i];
      }
      EXPECT_LT(difference, 0.1 * sum);
    }
  }
}

TEST(ExrFormat, MipLevelsAreMeansOfFourAndNumbersStay) {
  const support::TempDir directory;
  const Image image = picture(37, 22, {"G", "id.shape"});
  ASSERT_TRUE(write_exr(image, directory / "a.exr", {.tile_size = 16, .mipmaps = true}).ok());
  Imf::TiledInputFile file((directory / "a.exr").c_str());
  EXPECT_EQ(file.levelMode(), Imf::MIPMAP_LEVELS);
  EXPECT_EQ(file.numLevels(), 6);  // 37, 18, 9, 4, 2, 1
  const auto level = [&](const char* channel, int l) {
    const Imath::Box2i box = file.dataWindowForLevel(l);
    std::vector<float> values(
        static_cast<std::size_t>((box.max.x - box.min.x + 1) * (box.max.y - box.min.y + 1)));
    Imf::FrameBuffer frame;
    frame.insert(channel, Imf::Slice::Make(Imf::FLOAT, values.data(), box));
    file.setFrameBuffer(frame);
    file.readTiles(0, file.numXTiles(l) - 1, 0, file.numYTiles(l) - 1, l);
    return values;
  };
  EXPECT_EQ(level("G", 0), image.find("G")->values);
  for (const char* channel : {"G", "id.shape"}) {
    std::size_t width = 37;
    for (int l = 1; l < 6; ++l) {
      const std::vector<float> fine = level(channel, l - 1), coarse = level(channel, l);
      const std::size_t half = std::max<std::size_t>(width / 2, 1), lines = coarse.size() / half;
      const std::size_t right = width > 1 ? 1 : 0, below = fine.size() / width > 1 ? width : 0;
      for (std::size_t i = 0; i < coarse.size(); ++i) {
        const std::size_t corner = std::min(2 * (i / half), fine.size() / width - 1) * width + 2 * (i % half);
        const float mean = 0.25f * ((fine[corner] + fine[corner + right]) +
                                    (fine[corner + below] + fine[corner + below + right]));
        ASSERT_EQ(coarse[i], channel[0] == 'G' ? mean : fine[corner]) << channel << l << " of " << lines;
      }
      width = half;
    }
  }
}

TEST(ExrFormat, ChannelsAreCalledAsOthersCallThem) {
  const auto names = [](ChannelNames convention) {
    std::vector<std::string> result;
    for (const char* own : {"R", "depth.Z", "normal.X", "position.Y", "motion.U", "albedo.G", "caustics.B",
                            "id.shape", "samples", "CryptoObject00.R"})
      result.push_back(channel_name(own, convention));
    return result;
  };
  EXPECT_THAT(names(ChannelNames::kTessera),
              ElementsAre("R", "depth.Z", "normal.X", "position.Y", "motion.U", "albedo.G", "caustics.B",
                          "id.shape", "samples", "CryptoObject00.R"));
  EXPECT_THAT(
      names(ChannelNames::kBlender),
      ElementsAre("ViewLayer.Combined.R", "ViewLayer.Depth.Z", "ViewLayer.Normal.X", "ViewLayer.Position.Y",
                  "ViewLayer.Vector.X", "ViewLayer.Denoising Albedo.G", "ViewLayer.caustics.B",
                  "ViewLayer.IndexOB.X", "ViewLayer.Debug Sample Count.X", "ViewLayer.CryptoObject00.r"));
  EXPECT_THAT(names(ChannelNames::kNuke),
              ElementsAre("R", "Z", "N.X", "P.Y", "forward.u", "albedo.G", "caustics.B", "id.shape",
                          "samples", "CryptoObject00.R"));
  EXPECT_THAT(names(ChannelNames::kMitsuba),
              ElementsAre("R", "depth.T", "sh_normal.X", "position.Y", "motion.U", "albedo.G", "caustics.B",
                          "shape_index.I", "samples", "CryptoObject00.R"));
}

TEST(ExrFormat, HalfIsForTheLayersThatAreNamed) {
  const support::TempDir directory;
  const Image image = picture(8, 8, {"R", "A", "samples", "albedo.R", "normal.X", "normal.Y"});
  ASSERT_TRUE(write_exr(image, directory / "a.exr", {.half_layers = {"rgba", "normal.Y"}}).ok());
  const Imf::InputFile file((directory / "a.exr").c_str());
  std::vector<std::string> halves;
  for (auto it = file.header().channels().begin(); it != file.header().channels().end(); ++it) {
    if (it.channel().type == Imf::HALF) halves.push_back(it.name());
  }
  EXPECT_THAT(halves, ElementsAre("A", "R", "normal.Y"));
}

TEST(ExrFormat, CryptomatteIsNeverCompressedWithLoss) {
  const support::TempDir directory;
  const Image image = picture(8, 8, {"R", "CryptoObject00.R"});
  const absl::Status refused = write_exr(image, directory / "a.exr", {.compression = ExrCompression::kDwaa});
  EXPECT_EQ(refused.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(refused.message()), HasSubstr("--multipart"));
  ASSERT_TRUE(write_exr(image, directory / "a.exr",
                        {.half = true,
                         .half_layers = {"CryptoObject00"},
                         .multipart = true,
                         .compression = ExrCompression::kDwaa})
                  .ok());
  Imf::MultiPartInputFile file((directory / "a.exr").c_str());
  EXPECT_EQ(file.header(0).compression(), Imf::DWAA_COMPRESSION);
  EXPECT_EQ(file.header(1).compression(), Imf::ZIP_COMPRESSION);
  EXPECT_EQ(file.header(1).channels().begin().channel().type, Imf::FLOAT);
}

TEST(ExrFormat, TwoChannelsOfOneNameAreRefused) {
  const support::TempDir directory;
  const absl::Status status =
      write_exr(picture(4, 4, {"normal.X", "N.X"}), directory / "a.exr", {.names = ChannelNames::kNuke});
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("'N.X'"));
}

TEST(ExrFormat, StandardAttributesHaveTheirTypes) {
  const support::TempDir directory;
  Image image = picture(4, 4, {"R"});
  image.metadata["framesPerSecond"] = Rational{30000, 1001};
  image.metadata["timeCode"] = TimeCode{0x01020304, 0};
  RowMatrix matrix;
  for (std::size_t i = 0; i < 16; ++i) matrix.m[i] = static_cast<float>(i);
  image.metadata["worldToCamera"] = matrix;
  image.metadata["adoptedNeutral"] = NumberPair{.25f, .5f};
  image.metadata["cryptomatte/0123456/name"] = std::string("CryptoObject");
  ASSERT_TRUE(write_exr(image, directory / "a.exr",
                        {.names = ChannelNames::kBlender, .attributes = {{"owner", "Studio"}}})
                  .ok());
  const Imf::InputFile file((directory / "a.exr").c_str());
  EXPECT_EQ(Imf::framesPerSecond(file.header()).n, 30000);
  EXPECT_EQ(Imf::timeCode(file.header()).hours(), 1);
  EXPECT_EQ(Imf::timeCode(file.header()).minutes(), 2);
  EXPECT_EQ(Imf::timeCode(file.header()).seconds(), 3);
  EXPECT_EQ(Imf::timeCode(file.header()).frame(), 4);
  EXPECT_EQ(Imf::adoptedNeutral(file.header()).y, .5f);
  EXPECT_EQ(Imf::worldToCamera(file.header())[3][1], 13);
  EXPECT_EQ(Imf::owner(file.header()), "Studio");
  const absl::StatusOr<Image> facts = read_exr_facts(directory / "a.exr");
  ASSERT_TRUE(facts.ok()) << facts.status();
  for (const char* same : {"framesPerSecond", "timeCode", "worldToCamera", "adoptedNeutral"})
    EXPECT_EQ(facts->metadata.at(same), image.metadata.at(same)) << same;
  EXPECT_EQ(std::get<std::string>(facts->metadata.at("cryptomatte/0123456/name")), "ViewLayer.CryptoObject");
  EXPECT_EQ(facts->display, image.display);
}

/// Rows that are made when they are asked for.
class Ramp final : public Rows {
 public:
  absl::Status read(std::size_t plane, std::int32_t y, std::span<float> row) override {
    if (y == failing_row) return absl::InternalError("the disk is gone");
    for (std::size_t x = 0; x < row.size(); ++x)
      row[x] = static_cast<float>(plane * 10000 + static_cast<std::size_t>(y) * 100 + x);
    return absl::OkStatus();
  }
  std::int32_t failing_row = -1;
};

TEST(ExrFormat, RowsNeedNotBeInMemory) {
  const support::TempDir directory;
  Image image;
  image.data = image.display = {0, 0, 50, 40};
  image.channels = {{"R", {}}, {"a.G", {}}};
  Ramp ramp;
  for (const ExrFormat& format : {ExrFormat{}, ExrFormat{.multipart = true}, ExrFormat{.tile_size = 16}}) {
    ASSERT_TRUE(write_exr(image, ramp, directory / "a.exr", format).ok());
    const absl::StatusOr<Image> read = read_exr(directory / "a.exr");
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_EQ(read->find("R")->values[39 * 50 + 7], 3907);
  }
  ramp.failing_row = 20;
  const absl::Status failed = write_exr(image, ramp, directory / "b.exr", {});
  EXPECT_THAT(std::string(failed.message()), HasSubstr("the disk is gone"));
  EXPECT_FALSE(std::filesystem::exists(directory / "b.exr"));
}

/// Two views with two layers each, read one after the other, and by OpenEXR's own reader.
TEST(ExrFormat, ViewsArePartsOfAFile) {
  const support::TempDir directory;
  const std::string file = directory / "both.exr";
  Image left = picture(20, 10, {"R", "G", "B", "albedo.R"}), right = picture(20, 10, {"R", "G", "B"});
  right.channels[0].values[3] = 123;
  left.metadata["view"] = "left", right.metadata["view"] = "right";
  left.metadata["tessera.view"] = 0, right.metadata["tessera.view"] = 1;
  for (const bool layers : {false, true}) {
    const absl::Status written = write_exr_views({{{&left}, {&right}}}, file, {.multipart = layers});
    ASSERT_TRUE(written.ok()) << written;
    Imf::MultiPartInputFile parts(file.c_str());
    ASSERT_EQ(parts.parts(), layers ? 3 : 2);
    EXPECT_EQ(parts.header(0).name(), "rgba.left");
    EXPECT_EQ(parts.header(0).view(), "left");
    EXPECT_EQ(parts.header(layers ? 2 : 1).name(), "rgba.right");
    EXPECT_EQ(parts.header(layers ? 2 : 1).view(), "right");
    if (layers) {
      EXPECT_EQ(parts.header(1).name(), "albedo.left");
    }
    for (const Image* const view : {&left, &right}) {
      const auto read = read_exr(file, kMostImagePixels, std::get<std::string>(view->metadata.at("view")));
      ASSERT_TRUE(read.ok()) << read.status();
      EXPECT_EQ(read->channels.size(), view->channels.size());  // none of the other view's
      EXPECT_EQ(read->metadata.at("tessera.view"), view->metadata.at("tessera.view"));
      for (const Channel& channel : view->channels)
        EXPECT_EQ(read->find(channel.name)->values, channel.values) << channel.name;
    }
    EXPECT_EQ(read_exr(file)->find("R")->values, left.find("R")->values);
    EXPECT_THAT(std::string(read_exr(file, kMostImagePixels, "middle").status().message()),
                HasSubstr("has no view 'middle'; its views are left, right"));
  }
  right.metadata["view"] = "left";
  EXPECT_THAT(std::string(write_exr_views({{{&left}, {&right}}}, file, {}).message()),
              HasSubstr("have names that differ"));
}

}  // namespace
}  // namespace tessera::client::exr_format
