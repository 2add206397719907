// Scenes with motion as they are loaded: what is refused or warned of, and that only relative motion counts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "absl/strings/str_cat.h"
#include "render/scene/load_scene.h"
#include "support/picture/scene_file.h"
#include "wire/mesh_blob.h"

namespace tessera::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kFilm =
    "film { width: 32 height: 32 filter { kind: BOX } } lights { infinite { radiance { constant: 1 } } } ";
constexpr const char* kCamera = "camera { perspective { fov_degrees: 40 } } ";
constexpr const char* kAway = "elements: [1,0,0,0, 0,1,0,0, 0,0,1,5, 0,0,0,1]";

absl::StatusOr<LoadedFile> load_moving(const std::string& scene, std::uint32_t max_depth = 3,
                                       const TestBlobs& blobs = {}) {
  test::SceneJob job;
  job.settings.set_spp(64);
  job.settings.set_max_depth(max_depth);
  job.aovs.push_back(v1::AOV_DEPTH);
  return load_scene_text(absl::StrCat(scene, kFilm), job, render::supported_isas().front(), blobs);
}

TEST(MovingScene, FlatMotionIsRefusedByName) {
  const auto flat = load_moving(
      absl::StrCat(kCamera, "shapes { name: 'coin' sphere { radius: 1 } world_from_object { ", kAway,
                   " } world_from_object_end { elements: [1,0,0,0, 0,0,0,0, 0,0,1,5, 0,0,0,1] } }"));
  EXPECT_THAT(flat.status().message(), HasSubstr("shape 0 (coin)"));
  EXPECT_THAT(flat.status().message(), HasSubstr("singular"));
  const auto turned = load_moving(
      absl::StrCat(kCamera, "shapes { sphere { radius: 1 } world_from_object { ", kAway,
                   " } world_from_object_end { elements: [1,0,0,0, 0,-1,0,0, 0,0,1,5, 0,0,0,1] } }"));
  EXPECT_THAT(turned.status().message(), HasSubstr("shape 0: its motion turns it inside out"));
  const auto camera = load_moving(
      "camera { perspective { fov_degrees: 40 } world_from_camera_end { elements: [0,0,0,0, 0,1,0,0, "
      "0,0,1,0, 0,0,0,1] } }");
  EXPECT_THAT(camera.status().message(), HasSubstr("camera: "));
  const auto instance =
      load_moving(absl::StrCat(kCamera,
                               "objects { name: 'o' shapes { sphere { radius: 1 } } } instances { "
                               "object: 'o' world_from_instance_end { "
                               "elements: [1,0,0,0, 0,1,0,0, 0,0,0,0, 0,0,0,1] } }"));
  EXPECT_THAT(instance.status().message(), HasSubstr("instance 0 (o)"));
}

TEST(MovingScene, LampsMoveWithoutAWarning) {
  const auto file = load_moving(
      absl::StrCat(kCamera,
                   "shapes { name: 'lamp' sphere { radius: 1 } area_light { radiance { constant: 1 } } "
                   "world_from_object { ",
                   kAway,
                   " } world_from_object_end { "
                   "elements: [1,0,0,9, 0,1,0,0, 0,0,1,5, 0,0,0,1] } }"));
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_THAT(file->scene->warnings(), IsEmpty());
}

TEST(MovingScene, LightsThatCannotMoveSoAreRefusedByName) {
  const auto error_of = [](const std::string& light, const TestBlobs& blobs = {}) {
    return std::string(
        load_moving(absl::StrCat(kCamera, "lights { name: 'it' ", light, " }"), 3, blobs).status().message());
  };
  EXPECT_THAT(error_of("spot { target { z: 1 } intensity { constant: 1 } position_end { z: 1 } }"),
              AllOf(HasSubstr("light 0 (it)"), HasSubstr("no direction")));
  EXPECT_THAT(error_of("distant { direction { z: 1 } direction_end { } irradiance { constant: 1 } }"),
              AllOf(HasSubstr("light 0 (it)"), HasSubstr("no direction")));
  EXPECT_THAT(error_of("goniometric { intensity { constant: 1 } world_from_light_end { elements: "
                       "[1,0,0,0, 0,0,0,0, 0,0,1,0, 0,0,0,1] } }"),
              AllOf(HasSubstr("light 0 (it)"), HasSubstr("singular")));
  const std::string sky = "infinite { image { digest: 'sky' path: 'sky.pfm' } mapping: LATITUDE_LONGITUDE ",
                    texels(4 * 2 * 3 * sizeof(float), '\0');
  const TestBlobs blobs = {{"sky", "PF\n4 2\n-1.0\n" + texels}};
  EXPECT_THAT(
      error_of(sky + "world_from_light_end { elements: [0,1,0,0, -1,0,0,0, 0,0,1,0, 0,0,0,1] } portal { "
                     "z: 1 } portal { x: 1 z: 1 } portal { x: 1 y: 1 z: 1 } portal { y: 1 z: 1 } }",
               blobs),
      AllOf(HasSubstr("light 0 (it)"), HasSubstr("portal")));
  EXPECT_THAT(
      error_of(sky + "world_from_light_end { elements: [2,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1] } }", blobs),
      AllOf(HasSubstr("light 0 (it)"), HasSubstr("angles")));
}

wire::MeshData triangle(bool with_normals) {
  wire::MeshData mesh;
  mesh.positions = {0, 0, 5, 1, 0, 5, 0, 1, 5};
  if (with_normals) mesh.normals = {0, 0, -1, 0, 0, -1, 0, 0, -1};
  mesh.indices = {0, 1, 2};
  return mesh;
}

TEST(MovingScene, KeysOfAnotherMeshAreRefusedByName) {
  wire::MeshData larger = triangle(true);
  larger.positions.insert(larger.positions.end(), {1, 1, 5});
  larger.normals.insert(larger.normals.end(), {0, 0, -1});
  const TestBlobs blobs = {{"mesh", wire::encode_mesh(triangle(true))},
                           {"rough", wire::encode_mesh(triangle(false))},
                           {"larger", wire::encode_mesh(larger)},
                           {"points", std::string(4 * 4 * sizeof(float), '\0')},
                           {"starts", std::string(sizeof(std::uint32_t), '\0')}};
  const auto error_of = [&](const std::string& shape) {
    return std::string(load_moving(absl::StrCat(kCamera, "shapes { name: 'cloth' ", shape, " }"), 3, blobs)
                           .status()
                           .message());
  };
  const std::string mesh = "mesh { blob { digest: 'mesh' } ", same = "later_blobs { digest: 'mesh' } ";
  EXPECT_EQ(error_of(mesh + same + " }"), "");
  EXPECT_THAT(error_of(mesh + same + "later_blobs { digest: 'larger' } }"),
              AllOf(HasSubstr("shape 0 (cloth)"), HasSubstr("later_blobs[1]"), HasSubstr("4 vertices")));
  EXPECT_THAT(error_of(mesh + "later_blobs { digest: 'rough' } }"),
              AllOf(HasSubstr("shape 0 (cloth)"), HasSubstr("later_blobs[0]"), HasSubstr("no normals")));
  std::string many = mesh;
  for (int i = 0; i < 129; ++i) many += same;
  EXPECT_THAT(error_of(many + "}"), AllOf(HasSubstr("shape 0 (cloth)"), HasSubstr("at most 128")));
  EXPECT_THAT(error_of("curves { points { digest: 'points' } starts { digest: 'starts' } later_points { "
                       "digest: 'starts' } }"),
              AllOf(HasSubstr("shape 0 (cloth)"), HasSubstr("later_points[0]")));
  EXPECT_THAT(error_of(absl::StrCat("csg { parts { solid { ", mesh, same, " } } } }")),
              AllOf(HasSubstr("shape 0 (cloth)"), HasSubstr("deforms")));
}

TEST(MovingScene, AnEndThatIsTheStartIsNoMotion) {
  const auto file =
      load_moving(absl::StrCat(kCamera,
                               "shapes { sphere { radius: 1 } area_light { radiance { constant: 1 } } "
                               "world_from_object { ",
                               kAway, " } world_from_object_end { ", kAway, " } }"));
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_THAT(file->scene->warnings(), IsEmpty());
}

/// Sums over the samples of every pixel, of one channel.
std::vector<float> plane(const LoadedFile& file, const std::string& channel) {
  render::RenderStats stats;
  const auto tile = file.scene->render_tile({0, 0, 32, 32, 0, 64}, {}, stats);
  EXPECT_TRUE(tile.ok()) << tile.status();
  EXPECT_EQ(stats.dropped_samples, 0u);
  if (!tile.ok()) return {};
  for (std::size_t c = 0; c < tile->channels.size(); ++c) {
    if (tile->channels[c].name == channel)
      return {tile->values.begin() + 1024 * c, tile->values.begin() + 1024 * (c + 1)};
  }
  ADD_FAILURE() << "no channel " << channel;
  return {};
}

/// A cluster of all kinds of shapes but curves and meshes.
constexpr const char* kCluster = R"(
  objects { name: 'cluster'
    shapes { sphere { radius: 0.8 } world_from_object { elements: [1,0,0,0.7, 0,1,0,0, 0,0,1,5, 0,0,0,1] } }
    shapes { disk { radius: 0.9 } world_from_object { elements: [1,0,0,-0.7, 0,1,0,0.4, 0,0,-1,4, 0,0,0,1] } }
    shapes { cylinder { radius: 0.4 z_min: -1 z_max: 1 }
      world_from_object { elements: [1,0,0,-0.3, 0,0,1,-0.8, 0,-1,0,6, 0,0,0,1] } }
  }
)";

void expect_same(const std::string& camera_end, const std::string& world_end) {
  const auto moving_camera =
      load_moving(absl::StrCat(kCluster,
                               "instances { object: 'cluster' } camera { perspective { fov_degrees: 40 } "
                               "world_from_camera_end { elements: [",
                               camera_end, "] } }"));
  const auto moving_world = load_moving(
      absl::StrCat(kCluster, kCamera, "instances { object: 'cluster' world_from_instance_end { elements: [",
                   world_end, "] } }"));
  const auto still = load_moving(absl::StrCat(kCluster, kCamera, "instances { object: 'cluster' }"));
  ASSERT_TRUE(moving_camera.ok()) << moving_camera.status();
  ASSERT_TRUE(moving_world.ok()) << moving_world.status();
  ASSERT_TRUE(still.ok()) << still.status();
  const std::vector<float> a = plane(*moving_camera, "depth.Z"), b = plane(*moving_world, "depth.Z"),
                           c = plane(*still, "depth.Z");
  ASSERT_EQ(a.size(), b.size());
  int others = 0, blurred = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    // The same rays meet the same points, but for roundings at edges.
    others += std::abs(a[i] - b[i]) > 1e-4 * (a[i] + b[i]);
    blurred += std::abs(a[i] - c[i]) > 1e-2 * (a[i] + c[i]);
  }
  EXPECT_LE(others, 10);
  EXPECT_GT(blurred, 200);
}

TEST(MovingScene, ACameraThatSlidesIsAWorldThatSlidesTheOtherWay) {
  expect_same("1,0,0,0.5, 0,1,0,-0.3, 0,0,1,1, 0,0,0,1", "1,0,0,-0.5, 0,1,0,0.3, 0,0,1,-1, 0,0,0,1");
}

TEST(MovingScene, ACameraThatTurnsIsAWorldThatTurnsTheOtherWay) {
  // About y, by asin(0.28); both turn about the camera's origin.
  expect_same("0.96,0,0.28,0, 0,1,0,0, -0.28,0,0.96,0, 0,0,0,1",
              "0.96,0,-0.28,0, 0,1,0,0, 0.28,0,0.96,0, 0,0,0,1");
}

TEST(MovingScene, ShapesOfAnObjectMoveWithinIt) {
  // A shape that slides within an instance that slides: both ways add up, to the same as a shape of the
  // world.
  const auto within = load_moving(
      absl::StrCat(kCamera,
                   "objects { name: 'o' shapes { sphere { radius: 1 } world_from_object_end { elements: "
                   "[1,0,0,0.5, 0,1,0,0, 0,0,1,0, 0,0,0,1] } } } "
                   "instances { object: 'o' world_from_instance { ",
                   kAway,
                   " } world_from_instance_end { "
                   "elements: [1,0,0,0, 0,1,0,0.5, 0,0,1,5, 0,0,0,1] } }"));
  const auto alone =
      load_moving(absl::StrCat(kCamera, "shapes { sphere { radius: 1 } world_from_object { ", kAway,
                               " } world_from_object_end { "
                               "elements: [1,0,0,0.5, 0,1,0,0.5, 0,0,1,5, 0,0,0,1] } }"));
  ASSERT_TRUE(within.ok()) << within.status();
  ASSERT_TRUE(alone.ok()) << alone.status();
  for (const char* channel : {"depth.Z", "R"}) {
    const std::vector<float> a = plane(*within, channel), b = plane(*alone, channel);
    EXPECT_EQ(a, b) << channel;
  }
}

TEST(MovingScene, MirroredShapesKeepTheirFront) {
  // One-sided emission is not to be had of moving shapes; the side of a medium's border is: a sphere that
  // mirrors has its normals turned over, moving or not.
  const auto scene = [](const char* more) {
    return absl::StrCat(kCamera, R"(
      media { name: 'fog' extinction { constant { constant: 0.5 } } albedo { constant { constant: 0 } } }
      materials { name: 'none' interface { } }
      shapes { sphere { radius: 1 } material: 'none' interior_medium: 'fog'
               world_from_object { elements: [-1,0,0,0, 0,1,0,0, 0,0,1,5, 0,0,0,1] } )",
                        more, " } settings { integrator: 'volpath' }");
  };
  const auto still = load_moving(scene(""));
  const auto moving =
      load_moving(scene("world_from_object_end { elements: [-1,0,0,1e-6, 0,1,0,0, 0,0,1,5, 0,0,0,1] }"));
  ASSERT_TRUE(still.ok()) << still.status();
  ASSERT_TRUE(moving.ok()) << moving.status();
  const std::vector<float> a = plane(*still, "R"), b = plane(*moving, "R");
  double sum_a = 0, sum_b = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum_a += a[i], sum_b += b[i];
  // Absorption only: no noise beyond where rays fall, which are the same.
  EXPECT_NEAR(sum_a, sum_b, 1e-3 * sum_a);
}

}  // namespace
}  // namespace tessera::test
