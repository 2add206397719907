#include "wire/mesh_blob.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <random>

namespace tessera::wire {
namespace {

MeshData quad() {
  MeshData mesh;
  mesh.positions = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  mesh.normals = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
  mesh.uvs = {0, 0, 1, 0, 1, 1, 0, 1};
  mesh.indices = {0, 1, 2, 0, 2, 3};
  return mesh;
}

template <typename T>
std::vector<T> copy(std::span<const T> values) {
  return {values.begin(), values.end()};
}

TEST(MeshBlob, RoundTripsWithAndWithoutTheOptionalArrays) {
  for (const bool normals : {false, true}) {
    for (const bool uvs : {false, true}) {
      MeshData mesh = quad();
      if (!normals) mesh.normals.clear();
      if (!uvs) mesh.uvs.clear();
      const std::string blob = encode_mesh(mesh);
      const auto view = decode_mesh(blob);
      ASSERT_TRUE(view.ok()) << view.status();
      EXPECT_EQ(copy(view->positions), mesh.positions);
      EXPECT_EQ(copy(view->normals), mesh.normals);
      EXPECT_EQ(copy(view->uvs), mesh.uvs);
      EXPECT_EQ(copy(view->indices), mesh.indices);
    }
  }
}

TEST(MeshBlob, EveryArrayIsAligned) {
  MeshData mesh = quad();
  mesh.positions.resize(9);
  mesh.normals.resize(9);
  mesh.uvs.resize(6);
  mesh.indices = {0, 1, 2};
  const std::string blob = encode_mesh(mesh);
  const auto view = decode_mesh(blob);
  ASSERT_TRUE(view.ok()) << view.status();
  const auto offset = [&](const void* array) { return static_cast<const char*>(array) - blob.data(); };
  EXPECT_EQ(offset(view->positions.data()) % 16, 0);
  EXPECT_EQ(offset(view->normals.data()) % 16, 0);
  EXPECT_EQ(offset(view->uvs.data()) % 16, 0);
  EXPECT_EQ(offset(view->indices.data()) % 16, 0);
}

TEST(MeshBlob, NamesWhatIsWrong) {
  const auto message = [](std::string blob) { return std::string(decode_mesh(blob).status().message()); };
  const auto with_u64 = [](std::size_t offset, std::uint64_t value) {
    std::string blob = encode_mesh(quad());
    std::memcpy(blob.data() + offset, &value, 8);
    return blob;
  };
  EXPECT_THAT(message("TSR"), testing::HasSubstr("header"));
  EXPECT_THAT(message(std::string(64, 'x')), testing::HasSubstr("magic"));
  EXPECT_THAT(message(with_u64(16, 5)), testing::HasSubstr("bytes"));
  EXPECT_THAT(message(with_u64(16, std::uint64_t{1} << 40)), testing::HasSubstr("2^31"));
  EXPECT_THAT(message(with_u64(24, ~std::uint64_t{0})), testing::HasSubstr("2^31"));
  EXPECT_THAT(message(with_u64(8, 4)), testing::HasSubstr("flags"));

  MeshData mesh = quad();
  mesh.indices[4] = 4;
  EXPECT_THAT(message(encode_mesh(mesh)), testing::HasSubstr("index 4"));
  mesh = quad();
  mesh.positions[7] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(message(encode_mesh(mesh)), testing::HasSubstr("vertex 2"));
  mesh.positions[7] = std::numeric_limits<float>::infinity();
  EXPECT_THAT(message(encode_mesh(mesh)), testing::HasSubstr("vertex 2"));
}

// Every damage is an error or a mesh within bounds; sanitizers see the rest.
TEST(MeshBlob, SurvivesRandomDamage) {
  std::mt19937 random(7);
  const std::string sound = encode_mesh(quad());
  for (int round = 0; round < 2000; ++round) {
    std::string blob = sound.substr(0, random() % (sound.size() + 1));
    for (int i = 0; i < 3 && !blob.empty(); ++i) blob[random() % blob.size()] = static_cast<char>(random());
    const auto view = decode_mesh(blob);
    if (!view.ok()) continue;
    for (const std::uint32_t index : view->indices) EXPECT_LT(index, view->vertex_count());
  }
}

}  // namespace
}  // namespace tessera::wire
