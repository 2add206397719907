#include "image/cryptomatte.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"

namespace tessera::client::cryptomatte {
namespace {

TEST(Cryptomatte, HashesAreMurmurs) {
  // Published values of MurmurHash3_x86_32 with seed 0.
  EXPECT_EQ(matte_hash(""), 0u);
  EXPECT_EQ(matte_hash("hello"), 0x248bfa47u);
  EXPECT_EQ(matte_hash("hello, world"), 0x149bbb7fu);
  EXPECT_EQ(matte_hash("The quick brown fox jumps over the lazy dog"), 0x2e4ff723u);
  EXPECT_FLOAT_EQ(matte_identifier("hello"), 6.0705627102400005616e-17f);
}

TEST(Cryptomatte, IdentifiersAreNumbersThatPassThroughAnyProgram) {
  for (int i = 0; i < 20000; ++i) {
    const float identifier = matte_identifier(absl::StrCat("thing ", i));
    EXPECT_TRUE(std::isnormal(identifier)) << i;
  }
}

Image lists(const std::vector<std::vector<std::pair<float, float>>>& pixels) {
  Image image;
  image.data = image.display = {0, 0, static_cast<std::int32_t>(pixels.size()), 1};
  image.add("R");
  for (int entry = 0; entry < 8; ++entry) {
    image.add(absl::StrCat("crypto-object.id", entry));
    image.add(absl::StrCat("crypto-object.weight", entry));
  }
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    for (std::size_t entry = 0; entry < pixels[i].size(); ++entry) {
      image.channels[1 + 2 * entry].values[i] = pixels[i][entry].first;
      image.channels[2 + 2 * entry].values[i] = pixels[i][entry].second;
    }
  }
  return image;
}

const auto kNames = [](std::int64_t number) { return std::string(number < 3 ? "box" : "ball"); };

TEST(Cryptomatte, RanksAreByCoverageAndThingsOfOneNameAreOne) {
  Image image = lists({{{1, 0.25f}, {5, 0.4f}, {2, 0.35f}}, {}, {{5, 1.02f}, {1, -0.02f}}});
  resolve_mattes("crypto-object", "CryptoObject", 6, kNames, image);
  EXPECT_EQ(image.channels.size(), 1u + 12u);
  const auto at = [&](const char* channel, std::size_t pixel) { return image.find(channel)->values[pixel]; };
  EXPECT_EQ(at("CryptoObject00.R", 0), matte_identifier("box"));
  EXPECT_FLOAT_EQ(at("CryptoObject00.G", 0), 0.6f);
  EXPECT_EQ(at("CryptoObject00.B", 0), matte_identifier("ball"));
  EXPECT_FLOAT_EQ(at("CryptoObject00.A", 0), 0.4f);
  EXPECT_EQ(at("CryptoObject01.R", 0), 0);
  EXPECT_EQ(at("CryptoObject00.G", 1), 0);
  // Coverages beyond the unit interval are the filter's.
  EXPECT_EQ(at("CryptoObject00.G", 2), 1);
  EXPECT_EQ(at("CryptoObject00.A", 2), 0);
}

TEST(Cryptomatte, MetadataNameTheHashesOfWhatIsThere) {
  Image image = lists({{{1, 0.5f}, {7, 0.5f}}});
  resolve_mattes("crypto-object", "CryptoObject", 2, kNames, image);
  const std::string key = "cryptomatte/" +
                          absl::StrCat(absl::Hex(matte_hash("CryptoObject"), absl::kZeroPad8)).substr(0, 7) +
                          "/";
  EXPECT_EQ(std::get<std::string>(image.metadata.at(key + "name")), "CryptoObject");
  EXPECT_EQ(std::get<std::string>(image.metadata.at(key + "hash")), "MurmurHash3_32");
  EXPECT_EQ(std::get<std::string>(image.metadata.at(key + "conversion")), "uint32_to_float32");
  const auto manifest = nlohmann::json::parse(std::get<std::string>(image.metadata.at(key + "manifest")));
  EXPECT_EQ(manifest.size(), 2u);
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(matte_identifier("ball"));
  EXPECT_EQ(manifest.at("ball"), absl::StrCat(absl::Hex(bits, absl::kZeroPad8)));
}

}  // namespace
}  // namespace tessera::client::cryptomatte
