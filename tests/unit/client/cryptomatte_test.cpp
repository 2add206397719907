#include "image/cryptomatte.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

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

MatteList boxes_and_balls(std::uint32_t ranks) {
  return {
      .list = "crypto-object", .name = "CryptoObject", .ranks = ranks, .name_of = [](std::int64_t number) {
        return std::string(number < 3 ? "box" : "ball");
      }};
}

/// Values of the planes at a pixel of these identifiers and weights.
std::map<std::string, float> resolved(const std::vector<float>& entries, MatteResolver& resolver) {
  const std::vector<std::string> names = resolver.planes();
  std::vector<float> ranks(names.size(), -1);
  resolver.resolve(entries, ranks);
  std::map<std::string, float> planes;
  for (std::size_t i = 0; i < names.size(); ++i) planes[names[i]] = ranks[i];
  return planes;
}

TEST(Cryptomatte, RanksAreByCoverageAndThingsOfOneNameAreOne) {
  MatteResolver resolver(boxes_and_balls(6));
  EXPECT_EQ(resolver.planes().size(), 12u);
  std::map<std::string, float> planes = resolved({1, 0.25f, 5, 0.4f, 2, 0.35f}, resolver);
  EXPECT_EQ(planes.at("CryptoObject00.R"), matte_identifier("box"));
  EXPECT_FLOAT_EQ(planes.at("CryptoObject00.G"), 0.6f);
  EXPECT_EQ(planes.at("CryptoObject00.B"), matte_identifier("ball"));
  EXPECT_FLOAT_EQ(planes.at("CryptoObject00.A"), 0.4f);
  EXPECT_EQ(planes.at("CryptoObject01.R"), 0);
  planes = resolved({0, 0, 0, 0}, resolver);
  EXPECT_EQ(planes.at("CryptoObject00.G"), 0);
  // Coverages beyond the unit interval are the filter's.
  planes = resolved({5, 1.02f, 1, -0.02f}, resolver);
  EXPECT_EQ(planes.at("CryptoObject00.G"), 1);
  EXPECT_EQ(planes.at("CryptoObject00.A"), 0);
}

TEST(Cryptomatte, TakesAnyNumber) {
  MatteResolver resolver(boxes_and_balls(2));
  for (const float number : {1e30f, -1e30f, std::nanf(""), HUGE_VALF})
    EXPECT_EQ(resolved({number, 1}, resolver).at("CryptoObject00.R"), matte_identifier("box")) << number;
}

TEST(Cryptomatte, MetadataNameTheHashesOfWhatIsThere) {
  MatteResolver resolver(boxes_and_balls(2)), backwards(boxes_and_balls(2));
  for (const float number : {1.0f, 7.0f}) resolved({number, 0.5f}, resolver);
  for (const float number : {7.0f, 1.0f}) resolved({number, 0.5f}, backwards);
  Image image, same;
  resolver.describe(image), backwards.describe(same);
  EXPECT_EQ(image.metadata, same.metadata);
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
