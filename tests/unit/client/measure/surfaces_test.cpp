// Shapes of a scene as receivers: which side is measured, how large they are, and what is not read.
#include "measure/surfaces.h"

#include <gmock/gmock.h>

#include <numbers>
#include <string>

#include "google/protobuf/text_format.h"
#include "import/input/blob_collector.h"
#include "wire/mesh_blob.h"

namespace tessera::client {
namespace {

using Imath::V3d;
using testing::HasSubstr;

v1::Shape shape_of(const std::string& text) {
  v1::Shape shape;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &shape)) << text;
  return shape;
}

const char* const kMirror = " world_from_object { elements: [-2,0,0,0, 0,2,0,0, 0,0,2,0, 0,0,0,1] }";

/// A scene with one mesh: a square of 2 x 2 in z = 0 that faces up, and a triangle without area.
struct MeshScene {
  ImportedScene imported;
  v1::Shape shape;

  explicit MeshScene(const std::string& place = "") : shape(shape_of("name: 'floor'" + place)) {
    wire::MeshData mesh;
    mesh.positions = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    mesh.indices = {0, 1, 2, 1, 1, 3, 0, 2, 3};
    BlobCollector blobs;
    *shape.mutable_mesh()->mutable_blob() = blobs.add_bytes(wire::encode_mesh(mesh));
    imported.blobs = blobs.take();
  }
};

V3d normal_of(const CellTriangle& triangle) { return (triangle.edge_u % triangle.edge_v).normalized(); }

TEST(Surfaces, MeshesHaveACellForEachTriangle) {
  const MeshScene scene;
  const auto place = triangles_of(scene.shape, scene.imported, false);
  ASSERT_TRUE(place.ok()) << place.status();
  ASSERT_EQ(place->triangles.size(), 3u);
  EXPECT_EQ(place->positions.size(), 3u);
  EXPECT_DOUBLE_EQ(place->area, 4);
  EXPECT_DOUBLE_EQ(place->triangles[0].area(), 2);
  EXPECT_EQ(place->triangles[1].area(), 0);
  EXPECT_LT((place->positions[0] - V3d(1.0 / 3, -1.0 / 3, 0)).length(), 1e-12);
  EXPECT_FALSE(place->probe.inward());
  ASSERT_TRUE(place->mesh);
  EXPECT_EQ(place->mesh->shape, "floor");
  EXPECT_FALSE(place->mesh->turned);
  EXPECT_EQ(place->blobs.size(), 1u);
}

TEST(Surfaces, MirroredMeshesKeepTheirOutside) {
  // The geometric normal is turned over again where a transform mirrors (shape.proto).
  const MeshScene scene(kMirror);
  const auto place = triangles_of(scene.shape, scene.imported, false);
  ASSERT_TRUE(place.ok());
  EXPECT_GT(normal_of(place->triangles[0]).z, 0.999);
  EXPECT_DOUBLE_EQ(place->triangles[0].area(), 8);
  EXPECT_TRUE(place->mesh->turned) << "its triangles run clockwise now";
  const auto below = triangles_of(scene.shape, scene.imported, true);
  ASSERT_TRUE(below.ok());
  EXPECT_TRUE(below->probe.inward());
  EXPECT_FALSE(below->mesh->turned);
}

TEST(Surfaces, ProbesOfTrianglesShareOneMesh) {
  const CellTriangle triangle{.corner = {1, 2, 3}, .edge_u = {2, 0, 0}, .edge_v = {0, 0, 4}, .offset = 0.25};
  v1::Probe probe;
  place_on(triangle, probe);
  EXPECT_EQ(probe.mesh().mesh().digest(), unit_triangle().ref.digest());
  EXPECT_EQ(probe.offset(), 0.25);
  // Columns: both edges, the normal and the corner.
  const double expected[] = {2, 0, 0, 1, 0, 0, -1, 2, 0, 4, 0, 3, 0, 0, 0, 1};
  ASSERT_EQ(probe.mesh().world_from_mesh().elements_size(), 16);
  for (int i = 0; i < 16; ++i) EXPECT_EQ(probe.mesh().world_from_mesh().elements(i), expected[i]) << i;
}

TEST(Surfaces, BoxesAndConvexPolygonsAreMeshes) {
  const auto box = triangles_of(shape_of("box { low: [0,0,0] high: [1,2,3] }"), {}, false);
  ASSERT_TRUE(box.ok()) << box.status();
  EXPECT_EQ(box->triangles.size(), 12u);
  EXPECT_DOUBLE_EQ(box->area, 2 * (2 + 3 + 6));
  for (std::size_t t = 0; t < 12; ++t)
    EXPECT_GT((box->positions[t] - V3d(0.5, 1, 1.5)) ^ normal_of(box->triangles[t]), 0) << "outwards";
  const auto whole = surface_of(shape_of("polygon { corners: [0,0,0, 4,0,0, 4,3,0] }"), {}, false);
  ASSERT_TRUE(whole.ok()) << whole.status();
  EXPECT_DOUBLE_EQ(whole->area, 6);
  ASSERT_EQ(whole->blobs.size(), 1u);
  EXPECT_EQ(whole->probe.mesh().mesh().digest(), whole->blobs[0].ref.digest());
}

TEST(Surfaces, PolygonsThatAreNotConvexAreRefused) {
  const auto refused = [](const std::string& corners) {
    const auto place = surface_of(shape_of("polygon { corners: [" + corners + "] }"), {}, false);
    EXPECT_FALSE(place.ok());
    EXPECT_THAT(std::string(place.status().message()), HasSubstr("only convex ones")) << corners;
  };
  refused("0,0,0, 2,0,0, 0.5,0.5,0, 0,2,0");
  // A star turns left at every corner, and twice around.
  refused("1,0,0, -0.809,0.588,0, 0.309,-0.951,0, 0.309,0.951,0, -0.809,-0.588,0");
}

TEST(Surfaces, BallsAndDisksAreToldByWhatTheyAreInTheWorld) {
  const auto ball = surface_of(
      shape_of("ellipsoid { radii: [1,2,4] } world_from_object { elements: [4,0,0,0, 0,2,0,0, 0,0,1,0, "
               "0,0,0,1] }"),
      {}, false);
  ASSERT_TRUE(ball.ok()) << ball.status();
  EXPECT_DOUBLE_EQ(ball->probe.sphere().radius(), 4);
  // A disk has no height.
  const auto disk = surface_of(
      shape_of("disk { radius: 1 } world_from_object { elements: [2,0,0,0, 0,2,0,0, 0,0,7,0, 0,0,0,1] }"), {},
      false);
  ASSERT_TRUE(disk.ok()) << disk.status();
  EXPECT_DOUBLE_EQ(disk->area, 4 * std::numbers::pi);
  for (const char* const stretched :
       {"sphere { radius: 1 } world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,2,0, 0,0,0,1] }",
        // Axes of one length that are not at right angles.
        "sphere { radius: 1 } world_from_object { elements: [1,0.6,0,0, 0,0.8,0,0, 0,0,1,0, 0,0,0,1] }",
        "disk { radius: 1 } world_from_object { elements: [1,0.6,0,0, 0,0.8,0,0, 0,0,1,0, 0,0,0,1] }"})
    EXPECT_FALSE(surface_of(shape_of(stretched), {}, false).ok()) << stretched;
  EXPECT_TRUE(surface_of(shape_of("sphere { radius: 1 z_min: -1 z_max: 1 }"), {}, false).ok());
  EXPECT_FALSE(surface_of(shape_of("sphere { radius: 1 z_min: 0 }"), {}, false).ok());
}

TEST(Surfaces, MirroredSpheresLookInwards) {
  const std::string sphere = "sphere { radius: 1 }", ellipsoid = "ellipsoid { radii: [1,1,1] }";
  EXPECT_FALSE(surface_of(shape_of(sphere), {}, false)->probe.inward());
  EXPECT_TRUE(surface_of(shape_of(sphere + kMirror), {}, false)->probe.inward());
  EXPECT_FALSE(surface_of(shape_of(sphere + kMirror), {}, true)->probe.inward());
  EXPECT_FALSE(surface_of(shape_of(ellipsoid + kMirror), {}, false)->probe.inward());
}

TEST(Surfaces, ShapesWithoutTrianglesAreRefused) {
  const auto place = triangles_of(shape_of("sphere { radius: 1 }"), {}, false);
  ASSERT_FALSE(place.ok());
  EXPECT_THAT(std::string(place.status().message()), HasSubstr("it has no triangles"));
}

}  // namespace
}  // namespace tessera::client
