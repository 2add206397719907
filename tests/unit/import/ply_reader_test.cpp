#include "import/ply/ply_reader.h"

#include <algorithm>
#include <cstring>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace tessera::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

template <typename T>
void put(std::string& bytes, T value, bool big_endian) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (big_endian) std::reverse(raw, raw + sizeof(T));
  bytes.append(raw, sizeof(T));
}

std::string ascii_triangle() {
  return "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 3\nproperty float x\nproperty float y\n"
         "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
         "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
}

/// Two triangles over four vertices with normals and uvs, in an unusual order and with unusual types.
std::string binary_quad(bool big_endian, bool as_quad) {
  std::string bytes =
      std::string("ply\r\nformat ") + (big_endian ? "binary_big_endian" : "binary_little_endian") +
      " 1.0\r\nelement vertex 4\r\nproperty double y\r\nproperty short x\r\nproperty uchar quality\r\n"
      "property float z\r\nproperty float nx\r\nproperty float ny\r\nproperty float nz\r\n"
      "property float s\r\nproperty float t\r\nelement face " +
      (as_quad ? "1" : "2") +
      "\r\nproperty uchar flags\r\nproperty list ushort uint vertex_index\r\nend_header\r\n";
  const int xs[] = {0, 2, 2, 0}, ys[] = {0, 0, 3, 3};
  for (int v = 0; v < 4; ++v) {
    put<double>(bytes, ys[v], big_endian);
    put<std::int16_t>(bytes, static_cast<std::int16_t>(xs[v]), big_endian);
    put<std::uint8_t>(bytes, 7, big_endian);
    for (const float value : {5.f, 0.f, 0.f, 1.f, 0.25f * v, 0.5f}) put<float>(bytes, value, big_endian);
  }
  const std::vector<std::vector<std::uint32_t>> faces =
      as_quad ? std::vector<std::vector<std::uint32_t>>{{0, 1, 2, 3}}
              : std::vector<std::vector<std::uint32_t>>{{0, 1, 2}, {0, 2, 3}};
  for (const auto& face : faces) {
    put<std::uint8_t>(bytes, 1, big_endian);
    put<std::uint16_t>(bytes, static_cast<std::uint16_t>(face.size()), big_endian);
    for (const std::uint32_t index : face) put<std::uint32_t>(bytes, index, big_endian);
  }
  return bytes;
}

std::string error_of(std::string_view bytes) {
  const absl::StatusOr<PlyMesh> mesh = read_ply(bytes);
  EXPECT_FALSE(mesh.ok());
  return mesh.ok() ? "" : std::string(mesh.status().message());
}

TEST(PlyReader, ReadsAscii) {
  const absl::StatusOr<PlyMesh> ply = read_ply(ascii_triangle());
  ASSERT_TRUE(ply.ok()) << ply.status();
  EXPECT_THAT(ply->mesh.positions, ElementsAre(0, 0, 0, 1, 0, 0, 0, 1, 0));
  EXPECT_THAT(ply->mesh.indices, ElementsAre(0, 1, 2));
  EXPECT_TRUE(ply->mesh.normals.empty());
  EXPECT_TRUE(ply->warnings.empty());
}

TEST(PlyReader, ReadsBothByteOrdersAnyTypesAndOrders) {
  for (const bool big_endian : {false, true}) {
    for (const bool as_quad : {false, true}) {
      const absl::StatusOr<PlyMesh> ply = read_ply(binary_quad(big_endian, as_quad));
      ASSERT_TRUE(ply.ok()) << ply.status();
      EXPECT_THAT(ply->mesh.positions, ElementsAre(0, 0, 5, 2, 0, 5, 2, 3, 5, 0, 3, 5));
      EXPECT_THAT(ply->mesh.normals, ElementsAre(0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1));
      EXPECT_THAT(ply->mesh.uvs, ElementsAre(0, 0.5f, 0.25f, 0.5f, 0.5f, 0.5f, 0.75f, 0.5f));
      EXPECT_THAT(ply->mesh.indices, ElementsAre(0, 1, 2, 0, 2, 3));
      EXPECT_TRUE(ply->warnings.empty());  // a flat quad is exactly its two triangles
    }
  }
}

TEST(PlyReader, CutsPolygonsIntoFansAndSaysSo) {
  const absl::StatusOr<PlyMesh> ply = read_ply(
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 3\nproperty list uchar int vertex_indices\nelement edge 1\nproperty int a\nend_header\n"
      "0 0 0\n1 0 0\n1 1 1\n0 1 0\n0 .5 0\n"
      "5 0 1 2 3 4\n4 0 1 2 3\n2 0 1\n"
      "9\n");
  ASSERT_TRUE(ply.ok()) << ply.status();
  EXPECT_THAT(ply->mesh.indices, ElementsAre(0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 1, 2, 0, 2, 3));
  EXPECT_THAT(ply->warnings,
              ElementsAre(HasSubstr("quads are not flat"), HasSubstr("more than four vertices"),
                          HasSubstr("fewer than three vertices")));
}

TEST(PlyReader, RefusesEveryTruncation) {
  for (const std::string& whole : {binary_quad(false, true), binary_quad(true, false), ascii_triangle()}) {
    // The last byte of the ascii file is a line end that nothing needs, the one before a digit of which one
    // suffices.
    const std::size_t needed = whole == ascii_triangle() ? whole.size() - 1 : whole.size();
    for (std::size_t size = 0; size < needed; ++size) {
      EXPECT_FALSE(read_ply(std::string_view(whole).substr(0, size)).ok()) << size;
    }
  }
}

TEST(PlyReader, RefusesVerticesCutByOneByte) {
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\nelement face 0\nproperty list uchar int vertex_indices\nelement "
      "vertex 2\n"
      "property float x\nproperty float y\nproperty float z\nend_header\n";
  bytes.append(24, '\0');
  EXPECT_TRUE(read_ply(bytes).ok());
  bytes.pop_back();
  EXPECT_THAT(error_of(bytes), HasSubstr("it is cut off"));
}

TEST(PlyReader, NeverBelievesCounts) {
  // The file claims 10 GB and more; nothing of the kind is allocated.
  for (const char* count : {"900000000", "18446744073709551615"}) {
    std::string bytes = ascii_triangle();
    bytes.replace(bytes.find("vertex 3") + 7, 1, count);
    EXPECT_THAT(error_of(bytes), HasSubstr("the file ends after"));
    bytes = binary_quad(false, true);
    bytes.replace(bytes.find("face 1") + 5, 1, count);
    EXPECT_THAT(error_of(bytes), HasSubstr("the file ends after"));
  }
  std::string bytes = ascii_triangle();
  bytes.replace(bytes.find("3 0 1 2"), 1, "999999999");
  EXPECT_THAT(error_of(bytes), HasSubstr("face 0: the data end"));
}

TEST(PlyReader, LocatesWhatIsWrong) {
  const auto with = [](std::string_view what, std::string_view instead) {
    std::string bytes = ascii_triangle();
    bytes.replace(bytes.find(what), what.size(), instead);
    return error_of(bytes);
  };
  EXPECT_THAT(with("3 0 1 2", "3 0 1 3"),
              HasSubstr("triangle 0: vertex index 3 is out of range: there are 3"));
  EXPECT_THAT(with("3 0 1 2", "3 0 1 -1"), HasSubstr("line 14: face 0: vertex index -1 is out of range"));
  EXPECT_THAT(with("1 0 0", "1 nan 0"), HasSubstr("vertex 1: its position is not finite"));
  EXPECT_THAT(with("1 0 0", "1 1e39 0"), HasSubstr("vertex 1: its position is not finite"));
  EXPECT_THAT(with("1 0 0", "1 x 0"), HasSubstr("line 12: vertex 1: expected a number"));
  EXPECT_THAT(with("float y", "real y"), HasSubstr("line 6: unknown type \"real\""));
  EXPECT_THAT(with("property float z", "property float w"), HasSubstr("no properties x, y, z"));
  EXPECT_THAT(with("ascii", "text"), HasSubstr("line 2: expected \"format"));
  EXPECT_THAT(with("ply\n", "obj\n"), HasSubstr("not a PLY file"));
  EXPECT_THAT(with("element face", "element faces"), HasSubstr("no face element"));
  EXPECT_THAT(with("end_header", "endheader"), HasSubstr("line 10: expected format, element"));
  EXPECT_THAT(error_of(""), HasSubstr("not a PLY file"));
}

}  // namespace
}  // namespace tessera::client
