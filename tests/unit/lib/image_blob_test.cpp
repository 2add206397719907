// Files of every form that has a reader of its own are written with OpenImageIO, and read back both ways: by
// the reader and by OpenImageIO. The two must agree to the bit.
#include "images/image_blob.h"

#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "images/readers.h"

namespace tessera::images {
namespace {

constexpr std::uint64_t kNoLimit = std::uint64_t{1} << 28;
constexpr int kWidth = 37, kHeight = 23;

class ImageBlob : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "tessera-image-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    directory_ = pattern;
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }

  /// A file of noise.
  std::string file(const std::string& name, int channels, OIIO::TypeDesc type,
                   const char* attribute = nullptr, const char* value = nullptr) {
    path_ = (directory_ / name).string();
    const auto output = OIIO::ImageOutput::create(path_);
    OIIO::ImageSpec spec(kWidth, kHeight, channels, type);
    spec.attribute("oiio:UnassociatedAlpha", 1);
    if (attribute != nullptr) spec.attribute(attribute, value);
    std::mt19937 random(7);
    std::vector<float> values(static_cast<std::size_t>(kWidth * kHeight * channels));
    for (float& v : values) v = static_cast<float>(random() >> 8) / 16777216.0f;
    // Runs, for what encodes them.
    for (std::size_t i = 0; i < values.size() / 3; ++i)
      values[i] = values[static_cast<std::size_t>(i % 4 == 0)];
    EXPECT_TRUE(output->open(path_, spec) && output->write_image(OIIO::TypeDesc::FLOAT, values.data()) &&
                output->close())
        << name << output->geterror();
    return bytes_of(path_);
  }

  /// An EXR of these channels, in which the first is 0.5 everywhere, the second 0.25, and so on.
  std::string with_channels(const std::vector<std::string>& names) {
    path_ = (directory_ / "channels.exr").string();
    const auto output = OIIO::ImageOutput::create(path_);
    OIIO::ImageSpec spec(kWidth, kHeight, static_cast<int>(names.size()), OIIO::TypeDesc::FLOAT);
    spec.channelnames = names;
    spec.alpha_channel = -1;
    std::vector<float> values;
    for (int i = 0; i < kWidth * kHeight; ++i) {
      float value = 1;
      for (std::size_t c = 0; c < names.size(); ++c) values.push_back(value /= 2);
    }
    EXPECT_TRUE(output->open(path_, spec) && output->write_image(OIIO::TypeDesc::FLOAT, values.data()) &&
                output->close());
    return bytes_of(path_);
  }

  static std::string bytes_of(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  /// Pixels of the last file, as OpenImageIO reads it by itself.
  std::vector<float> reference() const {
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    const auto input = OIIO::ImageInput::open(path_, &config);
    const int channels = input->spec().nchannels;
    std::vector<float> values(static_cast<std::size_t>(kWidth * kHeight * channels));
    EXPECT_TRUE(input->read_image(0, 0, 0, channels, OIIO::TypeDesc::FLOAT, values.data()));
    std::vector<float> rgba;
    for (std::size_t i = 0; i < values.size(); i += static_cast<std::size_t>(channels)) {
      const float* v = &values[i];
      const float alpha = channels == 4 ? v[3] : channels == 2 ? v[1] : 1;
      rgba.insert(rgba.end(), {v[0], channels > 2 ? v[1] : v[0], channels > 2 ? v[2] : v[0], alpha});
    }
    return rgba;
  }

  void expect_same(const ImagePixels& pixels) const {
    ASSERT_EQ(pixels.size.width, kWidth);
    ASSERT_EQ(pixels.size.height, kHeight);
    std::vector<float> values = pixels.floats;
    for (const std::uint32_t pixel : pixels.bytes) {
      for (int c = 0; c < 4; ++c) values.push_back(static_cast<float>(pixel >> (8 * c) & 255) * (1.0f / 255));
    }
    EXPECT_EQ(values, reference());
  }

  /// That `reader` takes the file, and gives what OpenImageIO gives; and that it declines every beginning of
  /// it that lacks `must_have` bytes or more.
  void expect_own_reader(ImageReader reader, const std::string& bytes, std::size_t must_have) const {
    ImagePixels pixels;
    ASSERT_TRUE(reader(bytes, kNoLimit, pixels));
    expect_same(pixels);
    ImagePixels small;
    EXPECT_FALSE(reader(bytes, kWidth * kHeight - 1, small));
    for (std::size_t size = 0; size + must_have <= bytes.size(); size += 1 + bytes.size() / 200) {
      ImagePixels cut;
      EXPECT_FALSE(reader(bytes.substr(0, size), kNoLimit, cut)) << size << " bytes";
    }
  }

  std::filesystem::path directory_;
  std::string path_;
};

TEST_F(ImageBlob, PngAsOpenImageIoReadsIt) {
  for (const int channels : {1, 2, 3, 4}) {
    SCOPED_TRACE(channels);
    expect_own_reader(read_png, file("noise.png", channels, OIIO::TypeDesc::UINT8), 1);
  }
}

TEST_F(ImageBlob, JpegAsOpenImageIoReadsIt) {
  for (const int channels : {1, 3}) {
    SCOPED_TRACE(channels);
    expect_own_reader(read_jpeg, file("noise.jpg", channels, OIIO::TypeDesc::UINT8), 3);
  }
}

TEST_F(ImageBlob, TgaAsOpenImageIoReadsIt) {
  for (const char* compression : {"none", "rle"}) {
    for (const int channels : {1, 3}) {
      SCOPED_TRACE(testing::Message() << compression << " " << channels);
      constexpr std::size_t kFooterAndExtension = 26 + 495;
      const std::string bytes =
          file("noise.tga", channels, OIIO::TypeDesc::UINT8, "compression", compression);
      expect_own_reader(read_tga, bytes, kFooterAndExtension + 500);
    }
  }
}

TEST_F(ImageBlob, PfmAsOpenImageIoReadsIt) {
  for (const int channels : {1, 3}) {
    SCOPED_TRACE(channels);
    path_ = (directory_ / "noise.pfm").string();
    std::mt19937 random(3);
    std::string bytes = std::string(channels == 3 ? "PF" : "Pf") + "\n37 23\n-1.0\n";
    for (int i = 0; i < kWidth * kHeight * channels; ++i) {
      const float v = static_cast<float>(random()) * 1e-9f;
      bytes.append(reinterpret_cast<const char*>(&v), sizeof(v));
    }
    std::ofstream(path_, std::ios::binary) << bytes;
    expect_own_reader(read_pfm, bytes, 1);
  }
}

TEST_F(ImageBlob, ExrAsOpenImageIoReadsIt) {
  for (const char* compression : {"none", "zip", "piz"}) {
    for (const OIIO::TypeDesc type : {OIIO::TypeDesc::HALF, OIIO::TypeDesc::FLOAT}) {
      for (const int channels : {1, 3, 4}) {
        SCOPED_TRACE(testing::Message() << compression << " " << channels);
        expect_own_reader(read_exr, file("noise.exr", channels, type, "compression", compression), 1);
      }
    }
  }
}

TEST_F(ImageBlob, LeavesOtherFormsToOpenImageIo) {
  const struct {
    const char* name;
    int channels;
    OIIO::TypeDesc type;
    ImageReader reader;
  } forms[] = {{"sixteen.png", 3, OIIO::TypeDesc::UINT16, read_png},
               {"alpha.tga", 4, OIIO::TypeDesc::UINT8, read_tga},
               {"counts.exr", 3, OIIO::TypeDesc::UINT32, read_exr}};
  for (const auto& form : forms) {
    SCOPED_TRACE(form.name);
    const std::string bytes = file(form.name, form.channels, form.type);
    ImagePixels unused;
    EXPECT_FALSE(form.reader(bytes, kNoLimit, unused));
    const absl::StatusOr<ImagePixels> pixels = decode_image(bytes, form.name);
    ASSERT_TRUE(pixels.ok()) << pixels.status();
    expect_same(*pixels);
  }
}

/// The own readers and OpenImageIO both do.
TEST_F(ImageBlob, TellsTheSizeOfAFileFromItsHeader) {
  for (const char* name : {"noise.png", "noise.jpg", "noise.bmp", "noise.tif"}) {
    const std::string bytes = file(name, 3, OIIO::TypeDesc::UINT8);
    const std::string_view half = std::string_view(bytes).substr(0, bytes.size() / 2);
    const absl::StatusOr<ImageSize> size = image_size(name == std::string("noise.tif") ? bytes : half, name);
    ASSERT_TRUE(size.ok()) << size.status();
    EXPECT_EQ(size->width, kWidth);
    EXPECT_EQ(size->height, kHeight);
    const absl::Status large = image_size(bytes, name, kWidth * kHeight - 1).status();
    EXPECT_EQ(large, decode_image(bytes, name, kWidth * kHeight - 1).status());
    EXPECT_TRUE(absl::IsResourceExhausted(large)) << large;
  }
}

TEST_F(ImageBlob, AHeaderMayNotAskForMoreMemoryThanAFileIsWorth) {
  std::string bytes = file("wide.exr", 3, OIIO::TypeDesc::FLOAT);
  using std::string_literals::operator""s;
  const std::string window = "dataWindow\0box2i\0\x10\0\0\0"s;
  const std::size_t at = bytes.find(window);
  ASSERT_NE(at, std::string::npos);
  bytes.replace(at + window.size() + 8, 4,
                "\0\0\0\x05"s);  // 84 million pixels a line: OpenEXR makes room for some lines
  const absl::Status status = decode_image(bytes, "wide.exr").status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), testing::HasSubstr("image wide.exr: "));
  EXPECT_THAT(std::string(status.message()), testing::HasSubstr("256 MB"));
}

TEST_F(ImageBlob, RedAndGreenAloneAreNoGrey) {
  const std::string map = with_channels({"R", "G"}), grey = with_channels({"Y"});
  const auto both = decode_image(map, "map.exr"), one = decode_image(grey, "grey.exr");
  ASSERT_TRUE(both.ok() && one.ok()) << both.status() << one.status();
  EXPECT_THAT(std::vector<float>(both->floats.begin(), both->floats.begin() + 4),
              testing::ElementsAre(0.5f, 0.25f, 0, 1));
  EXPECT_THAT(std::vector<float>(one->floats.begin(), one->floats.begin() + 4),
              testing::ElementsAre(0.5f, 0.5f, 0.5f, 1));
}

TEST_F(ImageBlob, BandsOfASpectrumAreNoColours) {
  const std::vector<std::string> bands = {"S0.450,000000nm", "S0.500,000000nm", "S0.550,000000nm",
                                          "S0.600,000000nm"};
  const std::string light = with_channels(bands);
  for (const absl::Status& status :
       {decode_image(light, "bands.exr").status(), image_size(light, "bands.exr").status()}) {
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(status.message()),
                testing::HasSubstr("image bands.exr: it has 4 bands of a spectrum"));
  }
  EXPECT_FALSE(
      decode_image(with_channels({"T.450,000000nm", "T.500,000000nm", "T.550,000000nm"}), "m.exr").ok());
  // Colours beside them are what a texture takes.
  std::vector<std::string> beside = {"R", "G", "B"};
  beside.insert(beside.end(), bands.begin(), bands.end());
  EXPECT_TRUE(decode_image(with_channels(beside), "bands.exr").ok());
}

TEST_F(ImageBlob, SaysWhatIsWrongWithABrokenFile) {
  const std::string bytes = file("noise.png", 3, OIIO::TypeDesc::UINT8);
  const auto cut = decode_image(bytes.substr(0, bytes.size() / 2), "cut.png");
  EXPECT_EQ(cut.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(cut.status().message()), testing::HasSubstr("image cut.png: "));
  EXPECT_EQ(decode_image(bytes, "large.png", 100).status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(decode_image("not an image", "text.png").status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace tessera::images
