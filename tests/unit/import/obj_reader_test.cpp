#include "import/obj/obj_reader.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace tessera::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string error_of(const std::string& text) {
  const auto mesh = read_obj(text);
  EXPECT_FALSE(mesh.ok());
  return mesh.ok() ? "" : std::string(mesh.status().message());
}

TEST(ObjReader, MergesCornersWithTheSameIndices) {
  const auto mesh = read_obj(
      "# a quad of two triangles\r\no thing\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt "
      "0 1\n"
      "vn 0 0 1\ng group\nusemtl m\ns off\nf 1/1/1 2/2/1 3/3/1\nf 1/1/1 3/3/1 4/4/1\n");
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_THAT(mesh->mesh.indices, ElementsAre(0, 1, 2, 0, 2, 3));
  EXPECT_THAT(mesh->mesh.uvs, ElementsAre(0, 0, 1, 0, 1, 1, 0, 1));
  EXPECT_EQ(mesh->mesh.normals.size(), 12u);
  EXPECT_TRUE(mesh->warnings.empty());
}

TEST(ObjReader, SplitsAVertexWithTwoTextureCoordinates) {
  const auto mesh =
      read_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt .5 .5\nf 1/1 2/1 3/1\nf 2/2 4/1 3/1\n");
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_THAT(mesh->mesh.indices, ElementsAre(0, 1, 2, 3, 4, 2));
  EXPECT_EQ(mesh->mesh.positions[3 * 3], 1);  // vertex 3 is a copy of the file's second
  EXPECT_EQ(mesh->mesh.uvs[2 * 3], 0.5f);
}

TEST(ObjReader, CutsPolygonsIntoFansAndCountsFromTheEnd) {
  const auto mesh = read_obj("v 0 0 0\nv 1 0 0\nv 2 1 0\nv 1 2 0\nv 0 2 0\nf -5 -4 -3 -2 -1");
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_THAT(mesh->mesh.indices, ElementsAre(0, 1, 2, 0, 2, 3, 0, 3, 4));
  EXPECT_TRUE(mesh->mesh.uvs.empty());
  EXPECT_TRUE(mesh->mesh.normals.empty());
}

TEST(ObjReader, KeepsNormalsOnlyWhereAllCornersHaveOne) {
  const auto mesh = read_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3\n");
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_TRUE(mesh->mesh.normals.empty());
  EXPECT_THAT(mesh->warnings, ElementsAre(HasSubstr("1 corners have no normal")));
}

TEST(ObjReader, NamesTheLineOfAnError) {
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  EXPECT_THAT(error_of(corners + "f 1 2 4\n"),
              HasSubstr("line 4: vertex index 4 is out of range: there are 3"));
  EXPECT_THAT(error_of(corners + "f 1 2 0\n"), HasSubstr("line 4: vertex index 0"));
  EXPECT_THAT(error_of(corners + "f 1/1 2 3\n"), HasSubstr("texture coordinate index 1 is out of range"));
  EXPECT_THAT(error_of(corners + "f 1 2 x\n"), HasSubstr("line 4: expected a vertex index"));
  EXPECT_THAT(error_of("v 0 0\n"), HasSubstr("line 1: expected the 3 numbers of a position"));
  EXPECT_THAT(error_of("v 0 0 nan\n"), HasSubstr("line 1: a position is not finite"));
  EXPECT_THAT(error_of("v 0 0 1e99\n"), HasSubstr("line 1: a position is not finite"));
  EXPECT_THAT(error_of(corners), HasSubstr("no faces"));
  EXPECT_THAT(error_of(""), HasSubstr("no faces"));
}

}  // namespace
}  // namespace tessera::client
