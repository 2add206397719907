// Meshes with light, read back as their formats say.
#include "mesh/mesh_file.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <string_view>

#include "nlohmann/json.hpp"

namespace tessera::client {
namespace {

LitMesh triangle() {
  return {{{0, 0, 0}, {2, 0, 0}, {0, 3, -1}}, {{3.14159265f, 0, 0}, {0, 9, 0}, {0, 0, 0}}, {{0, 1, 2}}};
}

std::uint32_t number_at(std::string_view bytes, std::size_t place) {
  std::uint32_t number = 0;
  std::memcpy(&number, bytes.data() + place, sizeof(number));
  return number;
}

TEST(MeshFile, GlbHasTheMeshInItsAccessors) {
  const absl::StatusOr<std::string> glb = to_glb(triangle());
  ASSERT_TRUE(glb.ok()) << glb.status();
  const std::string_view bytes = *glb;
  ASSERT_GT(bytes.size(), 20u);
  EXPECT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(number_at(bytes, 8), bytes.size());
  const std::size_t described = number_at(bytes, 12);
  const auto document = nlohmann::json::parse(bytes.substr(20, described));
  const std::string_view data = bytes.substr(20 + described + 8);
  EXPECT_EQ(number_at(bytes, 20 + described), data.size());
  const auto& attributes = document["meshes"][0]["primitives"][0]["attributes"];
  const auto float_at = [&](const char* name, std::size_t vertex, std::size_t i) {
    const auto& accessor = document["accessors"][attributes[name].get<std::size_t>()];
    const auto& view = document["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    float value = 0;
    std::memcpy(&value, data.data() + view["byteOffset"].get<std::size_t>() + 12 * vertex + 4 * i,
                sizeof(value));
    return value;
  };
  EXPECT_EQ(float_at("POSITION", 2, 1), 3);
  EXPECT_NEAR(float_at("COLOR_0", 0, 0), 1, 1e-6f);
  EXPECT_EQ(float_at("COLOR_0", 1, 1), 1) << "clamped";
  EXPECT_EQ(float_at("_RADIOSITY", 1, 1), 9);
  EXPECT_EQ(document["accessors"][0]["min"], (nlohmann::json{0.0, 0.0, -1.0}));
  EXPECT_EQ(document["accessors"][0]["max"], (nlohmann::json{2.0, 3.0, 0.0}));
}

TEST(MeshFile, GlbRefusesMeshesThatItHasNoFormFor) {
  EXPECT_EQ(to_glb({}).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(mesh_bytes({}, "out.glb").status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_TRUE(mesh_bytes({}, "out.PLY").ok());
  EXPECT_TRUE(check_glb_size(100'000'000, 50'000'000).ok());
  for (const auto& [vertices, triangles] :
       {std::pair<std::uint64_t, std::uint64_t>{120'000'000, 1u << 30}, {1, 360'000'000}, {~0ull / 4, 1}}) {
    const absl::Status status = check_glb_size(vertices, triangles);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << vertices << ' ' << triangles;
    EXPECT_NE(status.message().find(std::to_string(vertices)), std::string::npos);
  }
}

TEST(MeshFile, PlySaysHowMuchFollows) {
  const std::string ply = to_ply(triangle());
  const std::size_t header = ply.find("end_header\n") + 11;
  EXPECT_NE(ply.find("element vertex 3\n"), std::string::npos);
  EXPECT_NE(ply.find("element face 1\n"), std::string::npos);
  EXPECT_EQ(ply.size() - header, 3u * 24 + 13);
}

}  // namespace
}  // namespace tessera::client
