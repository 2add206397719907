// Radiosity as users have it: its memory's limit on a farm, and the meshes that it is written to.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "integration/farm_under_test.h"

namespace tessera::integration::radiosity {  // apart from tests that are compiled with these
namespace {

using ::testing::HasSubstr;

const std::string kBox = "scenes/cornell-box/scene.pbrt";

Arguments job_with(const std::string& memory_limit) {
  return {kBox,
          "--integrator",
          "radiosity",
          "--set",
          "radiosity.error-bound=0.05",
          "--resolution",
          "32x32",
          "--spp",
          "2",
          "--set",
          "radiosity.memory-limit=" + memory_limit};
}

TEST(RadiosityOnAFarm, MemoryLimitsCoarsenLinksByTheSameBits) {
  // 36 triangles need some 300 KB; a megabyte has room for part of the links.
  FarmUnderTest farm;
  for (int i = 0; i < 2; ++i) farm.add_worker(1);
  std::vector<std::string> hashes;
  for (const char* limit : {"1M", "1G"}) {
    const std::string image = (farm.directory() / absl::StrCat(limit, ".exr")).string();
    const support::Finished done =
        tessera(farm.on_farm(Arguments{"submit"} + job_with(limit) + Arguments{"-o", image}));
    ASSERT_EQ(done.status.code, 0) << done.err;
    hashes.push_back(pixel_sha256(image));
    EXPECT_EQ(hashes.back(), expected_hash(job_with(limit) + Arguments{"--quiet"}));
    const bool warned = done.err.find("memory_limit has no room for more") != std::string::npos;
    EXPECT_EQ(warned, std::string(limit) == "1M") << done.err;
  }
  EXPECT_NE(hashes[0], hashes[1]) << "the limit must have been met";
}

TEST(RadiosityOnAFarm, TooLittleMemoryIsRefusedBeforeASampleIsTaken) {
  FarmUnderTest farm;
  farm.add_worker(1);
  const std::string image = (farm.directory() / "none.exr").string();
  const support::Finished done =
      tessera(farm.on_farm(Arguments{"submit"} + job_with("1K") + Arguments{"-o", image}));
  EXPECT_NE(done.status.code, 0);
  EXPECT_THAT(done.err, HasSubstr("radiosity of 36 triangles needs"));
  EXPECT_THAT(done.err, HasSubstr("--set radiosity.memory-limit"));
  EXPECT_FALSE(std::filesystem::exists(image));
}

// ---- meshes

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in{file, std::ios::binary};
  return {std::istreambuf_iterator<char>{in}, {}};
}

template <class T>
T value_at(const std::string& bytes, std::size_t at) {
  T value{};
  EXPECT_LE(at + sizeof(T), bytes.size());
  if (at + sizeof(T) <= bytes.size()) std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

struct Ply {
  std::size_t vertices = 0, faces = 0, data = 0;  // data: where it begins

  explicit Ply(const std::string& bytes) {
    const auto count_after = [&](const std::string& text) {
      const std::size_t at = bytes.find(text);
      EXPECT_NE(at, std::string::npos) << text;
      return at == std::string::npos ? 0 : std::stoul(bytes.substr(at + text.size(), 12));
    };
    vertices = count_after("element vertex "), faces = count_after("element face ");
    data = bytes.find("end_header\n") + 11;
  }
};

class Exports : public testing::Test {
 protected:
  std::string mesh(const std::string& name, const Arguments& more = {}) {
    const std::string file = (directory_.path() / name).string();
    const support::Finished done =
        tessera(Arguments{"radiosity", kBox, "-o", file, "--set", "radiosity.error-bound=0.05"} + more);
    EXPECT_EQ(done.status.code, 0) << done.err;
    said_ = done.err;
    return bytes_of(file);
  }

  support::TempDir directory_;
  std::string said_;
};

TEST_F(Exports, PlyHasTheLightOfTheBox) {
  const std::string bytes = mesh("box.ply");
  ASSERT_TRUE(bytes.starts_with("ply\nformat binary_little_endian 1.0\n"));
  const Ply ply(bytes);
  constexpr std::size_t kVertex = 6 * sizeof(float), kFace = 13;
  ASSERT_EQ(bytes.size(), ply.data + ply.vertices * kVertex + ply.faces * kFace);
  ASSERT_GT(ply.faces, 500u);
  // The box is 2 high and wide, and its lamp the brightest: pi times 17, 12 and 4.
  float brightest[3] = {};
  for (std::size_t i = 0; i < ply.vertices * 6; ++i) {
    const auto value = value_at<float>(bytes, ply.data + i * sizeof(float));
    ASSERT_TRUE(std::isfinite(value));
    if (i % 6 < 3) {
      ASSERT_LT(std::abs(value), 2.01f);
    } else {
      ASSERT_GE(value, 0);
      brightest[i % 6 - 3] = std::max(brightest[i % 6 - 3], value);
    }
  }
  const double lamp[3] = {17, 12, 4};
  for (int band = 0; band < 3; ++band)
    EXPECT_NEAR(brightest[band], M_PI * lamp[band], 0.01 * M_PI * lamp[band]) << band;
  for (std::size_t i = 0; i < ply.faces; ++i) {
    const std::size_t at = ply.data + ply.vertices * kVertex + i * kFace;
    ASSERT_EQ(bytes[at], 3);
    for (std::size_t corner = 0; corner < 3; ++corner)
      ASSERT_LT(value_at<std::uint32_t>(bytes, at + 1 + 4 * corner), ply.vertices);
  }
  EXPECT_EQ(mesh("again.ply"), bytes);
  // Less memory, fewer patches, and it says so.
  EXPECT_LT(Ply(mesh("small.ply", {"--set", "radiosity.memory-limit=1M"})).faces, ply.faces);
}

TEST_F(Exports, GltfHasTheSameMeshWithColoursOfVertices) {
  const std::string bytes = mesh("box.glb");
  ASSERT_TRUE(bytes.starts_with("glTF"));
  EXPECT_EQ(value_at<std::uint32_t>(bytes, 4), 2u);
  EXPECT_EQ(value_at<std::uint32_t>(bytes, 8), bytes.size());
  const auto length = value_at<std::uint32_t>(bytes, 12);
  EXPECT_EQ(bytes.substr(16, 4), "JSON");
  const auto document = nlohmann::json::parse(bytes.substr(20, length));
  const auto& primitive = document["meshes"][0]["primitives"][0];
  const auto accessor = [&](const char* name) {
    return document["accessors"][primitive["attributes"][name].get<std::size_t>()];
  };
  const Ply ply(mesh("box.ply"));
  for (const char* name : {"POSITION", "COLOR_0", "_RADIOSITY"}) {
    EXPECT_EQ(accessor(name)["count"], ply.vertices) << name;
    EXPECT_EQ(accessor(name)["type"], "VEC3");
  }
  EXPECT_EQ(document["accessors"][primitive["indices"].get<std::size_t>()]["count"], 3 * ply.faces);
  // The buffer is what the views say, and the file ends with it.
  std::size_t views = 0;
  for (const auto& view : document["bufferViews"]) views += view["byteLength"].get<std::size_t>();
  EXPECT_EQ(document["buffers"][0]["byteLength"], views);
  EXPECT_EQ(bytes.size(), 20 + length + 8 + (views + 3) / 4 * 4);
}

}  // namespace
}  // namespace tessera::integration::radiosity
