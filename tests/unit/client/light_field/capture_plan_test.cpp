// Where cameras of light fields stand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "unit/client/light_field/synthetic_set.h"

namespace tessera::client::light_field_test {
namespace {

using ::testing::HasSubstr;

constexpr ViewSize kWide{64, 32};

/// Where a camera sees a point, in pixels.
V3d seen_at(const Pinhole& camera, const V3d& p) {
  const auto from_world = light_field::inverse(camera.world_from_camera);
  const V3d q = light_field::transformed_point(*from_world, p);
  return {camera.cx + camera.fx * q.x / q.z, camera.cy - camera.fy * q.y / q.z, q.z};
}

TEST(CapturePlan, CamerasOfAGridSeeTheSamePartOfTheSecondPlane) {
  const CapturePlan plan = grid_plan(3, 0.5, 4, kWide);
  ASSERT_EQ(plan.cameras.size(), 9u);
  EXPECT_EQ(plan.cameras[0].place(), V3d(-0.5, 0.5, 0)) << "the upper left one comes first";
  const double half = 4 * std::tan(20 * M_PI / 180);
  for (const Pinhole& camera : plan.cameras) {
    const V3d corner = seen_at(camera, {-2 * half, half, 4});
    EXPECT_NEAR(corner.x, 0, 1e-9);
    EXPECT_NEAR(corner.y, 0, 1e-9);
    const V3d other = seen_at(camera, {2 * half, -half, 4});
    EXPECT_NEAR(other.x, 64, 1e-9);
    EXPECT_NEAR(other.y, 32, 1e-9);
  }
}

TEST(CapturePlan, MessagesOfCamerasSayTheSame) {
  v1::Scene scene;
  scene.mutable_camera()->set_medium("fog");
  scene.mutable_camera()->mutable_lens();
  const CapturePlan plan = grid_plan(2, 0.5, 4, kWide);
  set_cameras(plan.cameras, kWide, scene);
  ASSERT_EQ(scene.views_size(), 3);
  EXPECT_EQ(scene.views(2).medium(), "fog");
  ASSERT_TRUE(scene.camera().has_perspective());
  EXPECT_EQ(scene.camera().perspective().fov_degrees(), 90);
  const light_field::ImageWindow window = light_field::window_of(plan.cameras[3], 64, 32);
  EXPECT_EQ(scene.views(2).screen_window(0), static_cast<float>(window.x0));
  EXPECT_EQ(scene.views(2).screen_window(3), static_cast<float>(window.y1));
}

TEST(CapturePlan, ACameraWithoutAFieldOfViewNeedsOne) {
  v1::Camera camera;
  camera.mutable_orthographic();
  TwoPlaneRequest request;
  request.spacing_x = request.spacing_y = 0.1, request.focus = 3;
  EXPECT_THAT(std::string(plan_two_plane(request, camera, std::nullopt, kWide).status().message()),
              HasSubstr("--fov"));
  EXPECT_TRUE(plan_two_plane(request, camera, 30, kWide).ok());
}

TEST(CapturePlan, CamerasOnASphereSeeAllOfTheScene) {
  SceneBounds bounds;
  bounds.all = Imath::Box3d(V3d(1, 2, 3), V3d(3, 3, 5));
  SphereRequest request;
  request.cameras = 50;
  for (const bool mirrored : {false, true}) {
    const CapturePlan plan =
        plan_sphere(request, bounds, {V3d(0, 0, 1), mirrored}, std::nullopt, kWide).value();
    for (const Pinhole& camera : plan.cameras) {
      EXPECT_EQ(light_field::mirrors(camera.world_from_camera), mirrored);
      EXPECT_NEAR((camera.place() - V3d(2, 2.5, 4)).length(), 3 * 1.5, 1e-9);
      for (const V3d& corner : {bounds.all.min, bounds.all.max}) {
        const V3d at = seen_at(camera, corner);
        EXPECT_GT(at.z, 0);
        EXPECT_TRUE(at.x > 0 && at.x < 64 && at.y > 0 && at.y < 32) << at.x << " " << at.y;
      }
    }
  }
  request.radius = 1;
  EXPECT_THAT(std::string(plan_sphere(request, bounds, {}, std::nullopt, kWide).status().message()),
              HasSubstr("within the ball around the scene"));
}

TEST(CapturePlan, CamerasOfABoxSeeAllThatIsInIt) {
  SceneBounds bounds;
  bounds.shapes = {{"vase", Imath::Box3d(V3d(-1, 0, -1), V3d(1, 3, 1))},
                   {"floor", Imath::Box3d(V3d(-9, -1, -9), V3d(9, -0.9, 9))}};
  bounds.all = bounds.shapes[1].second;
  BoxRequest request;
  request.columns = 4, request.rows = 3;
  request.box.emplace(V3d(-1.5, -0.5, -1.5), V3d(1.5, 3.5, 1.5));
  const CapturePlan plan = plan_box(request, bounds, {}, std::nullopt, kWide).value();
  ASSERT_EQ(plan.arrangement.grids.size(), 6u);
  EXPECT_EQ(plan.arrangement.grids[0].name, "+x");
  ASSERT_EQ(plan.cameras.size(), 72u);
  for (const Pinhole& camera : plan.cameras) {
    EXPECT_TRUE(
        Imath::Box3d(V3d(-1.501, -0.501, -1.501), V3d(1.501, 3.501, 1.501)).intersects(camera.place()));
    for (const V3d& corner : {V3d(-1, 0, -1), V3d(1, 3, 1), V3d(-1, 3, 1), V3d(1, 0, -1)}) {
      const V3d at = seen_at(camera, corner);
      EXPECT_TRUE(at.z > 0 && at.x >= 0 && at.x <= 64 && at.y >= 0 && at.y <= 32) << at.x << " " << at.y;
    }
  }
}

TEST(CapturePlan, ABoxThatCutsShapesIsRefusedWithTheirNames) {
  SceneBounds bounds;
  bounds.shapes = {{"vase", Imath::Box3d(V3d(-1, 0, -1), V3d(1, 3, 1))},
                   {"flower", Imath::Box3d(V3d(-0.1, 2, -0.1), V3d(0.1, 5, 0.1))}};
  bounds.all = Imath::Box3d(V3d(-1, 0, -1), V3d(1, 5, 1));
  BoxRequest request;
  request.box.emplace(V3d(-1.5, -0.5, -1.5), V3d(1.5, 3.5, 1.5));
  const auto plan = plan_box(request, bounds, {}, std::nullopt, kWide);
  EXPECT_THAT(std::string(plan.status().message()), HasSubstr("cuts flower (-0.1,2,-0.1 to 0.1,5,0.1)"));
  request.box.emplace(V3d(10), V3d(11));
  EXPECT_THAT(std::string(plan_box(request, bounds, {}, std::nullopt, kWide).status().message()),
              HasSubstr("there is nothing in the box"));
  request.box.reset();
  EXPECT_TRUE(plan_box(request, bounds, {}, std::nullopt, kWide).ok()) << "the usual box is larger";
}

TEST(CapturePlan, SaysWhatWouldFit) {
  const std::uint64_t gigabyte = 1'000'000'000;
  EXPECT_TRUE(check_size(289, {512, 512}, true, 4 * gigabyte, 8 * gigabyte).ok());
  const absl::Status disk = check_size(65 * 65, {16384, 16384}, true, 200 * gigabyte, UINT64_MAX);
  EXPECT_TRUE(absl::IsOutOfRange(disk));
  EXPECT_THAT(std::string(disk.message()), HasSubstr("1.36e+04 GB on disk, and there are 200 GB"));
  EXPECT_THAT(std::string(disk.message()), HasSubstr("would fit"));
  EXPECT_THAT(std::string(check_size(289, {512, 512}, true, 4 * gigabyte, gigabyte / 2).message()),
              HasSubstr("of memory"));
}

}  // namespace
}  // namespace tessera::client::light_field_test
