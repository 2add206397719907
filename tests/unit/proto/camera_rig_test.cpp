// Rigs as the cameras that they stand for.
#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <string>

#include "wire/scene_views.h"

namespace tessera::wire {
namespace {

v1::Scene scene_of(const std::string& text) {
  v1::Scene scene;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &scene)) << text;
  return scene;
}

v1::Scene resolved(const std::string& text) {
  v1::Scene scene = scene_of(text);
  const absl::Status status = resolve_rig(scene);
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_FALSE(scene.has_rig());
  return scene;
}

std::string refusal(const std::string& text) {
  v1::Scene scene = scene_of(text);
  return std::string(resolve_rig(scene).message());
}

TEST(CameraRig, StereoPairsAreALeftAndARightView) {
  const v1::Scene scene = resolved(R"(
      camera { perspective { fov_degrees: 40 }
               world_from_camera { elements: [1,0,0,5, 0,1,0,6, 0,0,1,7, 0,0,0,1] } }
      rig { stereo { interocular_distance: 0.065 axes: TOE_IN convergence_distance: 3 } })");
  ASSERT_EQ(scene.views_size(), 1);
  EXPECT_EQ(scene.camera().view_name(), "left");
  EXPECT_EQ(scene.camera().viewpoint().x(), -0.0325);
  EXPECT_EQ(scene.views(0).view_name(), "right");
  EXPECT_EQ(scene.views(0).viewpoint().x(), 0.0325);
  for (const v1::Camera& eye : {scene.camera(), scene.views(0)}) {
    EXPECT_EQ(eye.perspective().fov_degrees(), 40);
    EXPECT_EQ(eye.viewpoint().axes(), v1::Viewpoint::TOE_IN);
    EXPECT_EQ(eye.viewpoint().convergence_distance(), 3);
  }
  // They share what is built of the scene.
  EXPECT_EQ(scene.render_origin().z(), 7);
}

TEST(CameraRig, GridsGoFromLeftToRightAndFromTheTop) {
  const v1::Scene scene = resolved(
      "camera { } rig { grid { columns: 3 rows: 2 spacing_x: 0.1 spacing_y: 0.4 convergence_distance: 2 } }");
  ASSERT_EQ(scene.views_size(), 5);
  const double x[] = {-0.1, 0, 0.1, -0.1, 0, 0.1}, y[] = {0.2, 0.2, 0.2, -0.2, -0.2, -0.2};
  for (std::uint32_t view = 0; view < 6; ++view) {
    EXPECT_NEAR(camera_of(scene, view).viewpoint().x(), x[view], 1e-15);
    EXPECT_NEAR(camera_of(scene, view).viewpoint().y(), y[view], 1e-15);
  }
}

TEST(CameraRig, ListsPlaceTheirCamerasRelativeToTheScenes) {
  const v1::Scene scene = resolved(R"(
      camera { world_from_camera { elements: [0,0,1,5, 0,1,0,6, -1,0,0,7, 0,0,0,1] }
               world_from_camera_end { elements: [1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1] } }
      rig { list { places { name: 'first' camera_from_view { elements: [1,0,0,2, 0,1,0,3, 0,0,1,4, 0,0,0,1] } }
                   places { } } })");
  ASSERT_EQ(scene.views_size(), 1);
  EXPECT_EQ(scene.camera().view_name(), "first");
  const auto& place = scene.camera().world_from_camera().elements();
  EXPECT_THAT(std::vector<double>(place.begin(), place.end()),
              testing::ElementsAre(0, 0, 1, 9, 0, 1, 0, 9, -1, 0, 0, 5, 0, 0, 0, 1));
  EXPECT_EQ(scene.camera().world_from_camera_end().elements(3), 3);
  EXPECT_EQ(scene.views(0).world_from_camera().elements(3), 5);
}

TEST(CameraRig, WithoutSenseIsRefused) {
  EXPECT_EQ(refusal("camera { } rig { }"), "rig: it has no kind, or one that is unknown");
  EXPECT_EQ(refusal("camera { } views { } rig { stereo { } }"),
            "rig: a scene with a rig has no views beside");
  EXPECT_EQ(refusal("camera { viewpoint { x: 1 } } rig { stereo { } }"),
            "rig: its camera has a viewpoint of its own");
  EXPECT_EQ(refusal("camera { } rig { grid { columns: 3 } }"),
            "rig: a grid has 1 to 4096 cameras, not 3 x 0");
  EXPECT_EQ(refusal("camera { } rig { grid { columns: 4000000000 rows: 4000000000 } }"),
            "rig: a grid has 1 to 4096 cameras, not 4000000000 x 4000000000");
  EXPECT_EQ(refusal("camera { } rig { list { } }"), "rig: its list has no cameras");
  EXPECT_EQ(refusal("camera { } rig { list { places { camera_from_view { elements: [1, 2] } } } }"),
            "rig: a matrix has 2 elements instead of 16");
  // Both eyes in one place are allowed.
  EXPECT_EQ(refusal("camera { } rig { stereo { } }"), "");
}

}  // namespace
}  // namespace tessera::wire
