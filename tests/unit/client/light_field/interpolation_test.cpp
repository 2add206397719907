// Pictures of light fields against the formulas that the views were made of.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/camera_rays.h"
#include "capture/pictures.h"
#include "unit/client/light_field/synthetic_set.h"

namespace tessera::client::light_field_test {
namespace {

using light_field::Interpolation;
using ::testing::HasSubstr;

constexpr ViewSize kViews{96, 96};

/// A camera behind the grid, off its middle, that sees less than the views do.
Pinhole eye_behind() {
  Pinhole eye;
  eye.world_from_camera = light_field::looking({0.06, -0.04, -0.3}, {0.01, 0.02, 1}, {0, 1, 0}, false);
  light_field::set_window({-0.2, 0.2, -0.2, 0.2}, 64, 64, eye);
  return eye;
}

/// Linear interpolation between pixels `step` apart errs by step^2 / 8 times the largest second derivative,
/// for each axis; that of waves() is 0.15 * 4^2. `z`: the farthest that is seen. Floats add 1e-5.
double interpolation_bound(double z) {
  const double step = 2 * std::tan(0.349066) * z / kViews.width;
  return 2 * step * step / 8 * 0.15 * 16 + 1e-5;
}

light_field::Picture look_up(LightField& field, const Pinhole& eye, Interpolation by, int threads = 1) {
  light_field::PictureRequest request = request_of(eye, 64, 64, by);
  request.threads = threads;
  auto picture = interpolate(field, request);
  EXPECT_TRUE(picture.ok()) << picture.status();
  return *std::move(picture);
}

TEST(LightFieldInterpolation, QuadrilinearIsExactOnTheSecondPlane) {
  const support::TempDir directory;
  const Shader shade = plane(5, 0, waves);
  write_set(directory / "a.lf", grid_plan(5, 0.1, 5, kViews), kViews, shade);
  const auto field = open(directory / "a.lf");
  const light_field::Picture picture = look_up(*field, eye_behind(), Interpolation::kQuadrilinear);
  EXPECT_EQ(picture.missing, 0u);
  EXPECT_EQ(picture.rays, 64u * 64);
  EXPECT_LT(worst_error(picture, eye_behind(), shade), interpolation_bound(5));
}

TEST(LightFieldInterpolation, DepthMakesItExactOnAnyPlane) {
  const support::TempDir directory;
  for (const double slope : {0.0, 0.3}) {
    for (const double height : {3.0, 9.0}) {
      const std::string folder = directory / absl::StrCat(height, "-", slope);
      const Shader shade = plane(height, slope, waves);
      write_set(folder, grid_plan(5, 0.4, 5, kViews), kViews, shade);
      const auto field = open(folder);
      // Pixels of a sloping plane lie farther apart, by 1 / (1 - slope tan) at most, and it reaches farther.
      const double stretch = 1 / (1 - slope * 0.37);
      const double bound = interpolation_bound(height * stretch * stretch);
      const double with =
          worst_error(look_up(*field, eye_behind(), Interpolation::kDepth), eye_behind(), shade);
      EXPECT_LT(with, bound) << "plane at " << height << ", slope " << slope;
      // Neighbours see it 0.4 (9 - 5) / 5 = 0.32 apart: midway between them, the mean of two places of a wave
      // is wrong by 0.15 (1 - cos(4 * 0.16)) = 0.03.
      if (height == 9) {
        const double without =
            worst_error(look_up(*field, eye_behind(), Interpolation::kQuadrilinear), eye_behind(), shade);
        EXPECT_GT(without, 0.02);
        EXPECT_LT(bound, 0.01);
      }
    }
  }
}

TEST(LightFieldInterpolation, LumigraphIsExactOnPlanesOfKnownDepth) {
  const support::TempDir directory;
  const Shader shade = plane(6, 0, waves);
  write_set(directory / "a.lf", grid_plan(4, 0.15, 5, kViews), kViews, shade);
  const auto field = open(directory / "a.lf");
  const light_field::Picture picture = look_up(*field, eye_behind(), Interpolation::kLumigraph);
  EXPECT_EQ(picture.missing, 0u);
  EXPECT_LT(worst_error(picture, eye_behind(), shade), interpolation_bound(6));
}

TEST(LightFieldInterpolation, LumigraphSeesABallFromAllAround) {
  const support::TempDir directory;
  // A ball of radius 1 about the origin, whose colour is a function of the place, and nothing around it.
  const Shader shade = [](const V3d& origin, const V3d& direction) {
    const V3d d = direction.normalized();
    const double b = origin.dot(d), c = origin.length2() - 1, root = b * b - c;
    if (root < 0 || b > 0) return Shade{};
    const double t = -b - std::sqrt(root);
    return Shade{0.5 + 0.3 * (origin + t * d).y, t};
  };
  SceneBounds bounds;
  bounds.all = Imath::Box3d(V3d(-1), V3d(1));
  SphereRequest request;
  request.cameras = 80;
  request.radius = 4;
  const CapturePlan plan = plan_sphere(request, bounds, {}, std::nullopt, kViews).value();
  write_set(directory / "a.lf", plan, kViews, shade);
  const auto field = open(directory / "a.lf");
  EXPECT_THAT(
      std::string(
          interpolate(*field, request_of(eye_behind(), 8, 8, Interpolation::kDepth)).status().message()),
      HasSubstr("its views stand in no grid"));
  Pinhole eye;
  eye.world_from_camera = light_field::looking({2, 1, -2.5}, {-2, -1, 2.5}, {0, 1, 0}, false);
  light_field::set_window({-0.15, 0.15, -0.15, 0.15}, 64, 64, eye);  // within the ball
  const light_field::Picture picture = look_up(*field, eye, Interpolation::kLumigraph);
  EXPECT_EQ(picture.missing, 0u);
  // The colour is linear in y, and changes by 0.3 a unit of length. The place is wrong by what a step to the
  // depth beside it leaves: less than a pixel of the views, 4 * 2 * 0.5 / 96.
  EXPECT_LT(worst_error(picture, eye, shade), 0.3 * 4 * 2 * 0.5 / 96);
}

TEST(LightFieldInterpolation, MissingRaysAreCountedAndMarked) {
  const support::TempDir directory;
  const Shader shade = plane(5, 0, waves);
  write_set(directory / "a.lf", grid_plan(5, 0.1, 5, kViews), kViews, shade);
  const auto field = open(directory / "a.lf");
  // From one unit behind, rays of slopes to 0.4 cross the grid, of half width 0.2, at half of the window's.
  Pinhole eye;
  eye.world_from_camera[11] = -1;
  light_field::set_window({-0.4, 0.4, -0.4, 0.4}, 64, 64, eye);
  for (const Interpolation by : {Interpolation::kQuadrilinear, Interpolation::kDepth}) {
    const light_field::Picture picture = look_up(*field, eye, by);
    EXPECT_EQ(picture.rays - picture.missing, 32u * 32);
    EXPECT_EQ(picture.known[0], 0);
    EXPECT_EQ(picture.pixels[0][3], 0);
    EXPECT_EQ(picture.known[32 * 64 + 32], 1);
    EXPECT_NEAR(picture.pixels[32 * 64 + 32][3], 1, 1e-6);
  }
  // The other way round, there is nothing.
  eye.world_from_camera = light_field::looking({0, 0, -1}, {0, 0, -1}, {0, 1, 0}, false);
  const light_field::Picture back = look_up(*field, eye, Interpolation::kDepth);
  EXPECT_EQ(back.missing, back.rays);
}

TEST(LightFieldInterpolation, HasTheSameBitsWithAnyNumberOfThreads) {
  const support::TempDir directory;
  write_set(directory / "a.lf", grid_plan(3, 0.2, 5, kViews), kViews, plane(6, 0.2, waves));
  for (const Interpolation by :
       {Interpolation::kQuadrilinear, Interpolation::kDepth, Interpolation::kLumigraph}) {
    const light_field::Picture one = look_up(*open(directory / "a.lf"), eye_behind(), by, 1);
    const light_field::Picture three = look_up(*open(directory / "a.lf"), eye_behind(), by, 3);
    EXPECT_EQ(one.known, three.known);
    for (std::size_t i = 0; i < one.pixels.size(); ++i) {
      for (int c = 0; c < 4; ++c) ASSERT_EQ(one.pixels[i][c], three.pixels[i][c]) << i;
    }
  }
}

TEST(LightFieldInterpolation, ABoxIsSeenFromOutsideAndFromWithin) {
  const support::TempDir directory;
  SceneBounds bounds;
  bounds.shapes.emplace_back("cube", Imath::Box3d(V3d(-0.5), V3d(0.5)));
  bounds.all = bounds.shapes[0].second;
  // The colour of what is seen depends on the direction alone, so that all depths are the same.
  const Shader shade = [](const V3d&, const V3d& direction) {
    return Shade{0.5 + 0.2 * direction.normalized().y, 0};
  };
  for (const bool outwards : {false, true}) {
    BoxRequest request;
    request.columns = request.rows = 3;
    request.box.emplace(V3d(-1), V3d(1));
    request.outwards = outwards;
    const CapturePlan plan = plan_box(request, bounds, {}, 120, kViews).value();
    ASSERT_EQ(plan.cameras.size(), 54u);
    const std::string folder = directory / (outwards ? "out.lf" : "in.lf");
    write_set(folder, plan, kViews, shade);
    const auto field = open(folder);
    Pinhole eye;
    eye.world_from_camera =
        light_field::looking(outwards ? V3d(0.1, 0.2, 0) : V3d(2, 1, -3),
                             outwards ? V3d(1, 0.5, 0.8) : V3d(-2, -1, 3), {0, 1, 0}, false);
    light_field::set_window({-0.1, 0.1, -0.1, 0.1}, 64, 64, eye);
    const light_field::Picture picture = look_up(*field, eye, Interpolation::kDepth);
    EXPECT_EQ(picture.missing, 0u);
    // Cameras see a point that is 1e4 times as far as they in the direction of the eye's ray, but for 1e-4 of
    // it; pixels of 2 tan(60 degrees) / 96 err by less.
    EXPECT_LT(worst_error(picture, eye, shade), 1e-3);
  }
}

TEST(CameraRays, AreThoseOfTheDocuments) {
  v1::Camera camera;
  camera.mutable_panorama();
  const ViewSize size{8, 4};
  std::vector<Ray> row(8);
  camera_rays(camera, size).value()(1, row);
  // The middle of the film looks along z; to the right of it, x grows. Row 1 of 4 lies 22.5 degrees above.
  const double up = 22.5 * M_PI / 180;
  EXPECT_NEAR(row[4].direction.y, std::sin(up), 1e-12);
  EXPECT_NEAR(row[4].direction.x, std::cos(up) * std::sin(up), 1e-12);
  EXPECT_NEAR(row[4].direction.z, std::cos(up) * std::cos(up), 1e-12);
  camera.mutable_spherical();
  camera_rays(camera, {4, 3}).value()(1, std::span(row).first(4));
  // docs/cameras.md: the middle looks along -x; of four columns, the second and third lie 45 degrees aside.
  EXPECT_NEAR(row[1].direction.x, -std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(row[2].direction.x, -std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(row[2].direction.z, -std::sqrt(0.5), 1e-12);
  camera.mutable_fisheye()->set_fov_degrees(180);
  camera_rays(camera, {3, 3}).value()(1, std::span(row).first(3));
  EXPECT_NEAR(row[2].direction.x, std::sin(M_PI / 3), 1e-12);
  EXPECT_NEAR(row[2].direction.z, std::cos(M_PI / 3), 1e-12);
  camera.mutable_orthographic();
  camera_rays(camera, {2, 2}).value()(0, std::span(row).first(2));
  EXPECT_EQ(row[1].origin, V3d(0.5, 0.5, 0));
  camera.mutable_cube_map();
  EXPECT_THAT(std::string(camera_rays(camera, size).status().message()), HasSubstr("it is none whose rays"));
}

TEST(CameraRays, OfAViewpointMeetTheConvergencePlaneWithTheOthers) {
  v1::Camera camera;
  camera.mutable_perspective()->set_fov_degrees(50);
  std::vector<Ray> middle(5), aside(5);
  camera_rays(camera, {5, 5}).value()(3, middle);
  camera.mutable_viewpoint()->set_x(0.3);
  camera.mutable_viewpoint()->set_y(-0.1);
  camera.mutable_viewpoint()->set_convergence_distance(4);
  camera_rays(camera, {5, 5}).value()(3, aside);
  for (std::size_t x = 0; x < 5; ++x) {
    const V3d there = middle[x].origin + 4.0 * middle[x].direction;
    EXPECT_LT((aside[x].origin + 4.0 * aside[x].direction - there).length(), 1e-12);
  }
}

TEST(Quilts, BeginAtTheLowerLeft) {
  const support::TempDir directory;
  const Shader shade = plane(5, 0, waves);
  const ViewSize size{16, 12};
  const CapturePlan plan = grid_plan(3, 0.2, 5, size);
  write_set(directory / "a.lf", plan, size, shade);
  const auto field = open(directory / "a.lf");
  const auto quilt = quilt_of(*field, {3, 1}, Interpolation::kQuadrilinear, 1);
  ASSERT_TRUE(quilt.ok()) << quilt.status();
  EXPECT_EQ(quilt->width, 48u);
  EXPECT_EQ(quilt->missing, 0u);
  // Three views of three columns are those of the middle row.
  for (std::size_t view = 0; view < 3; ++view) {
    const Image truth = shaded(plan.cameras[3 + view], 16, 12, shade);
    for (std::size_t y = 0; y < 12; ++y) {
      for (std::size_t x = 0; x < 16; ++x) {
        EXPECT_NEAR(quilt->pixels[y * 48 + view * 16 + x][0], truth.channels[0].values[y * 16 + x], 1e-5);
      }
    }
  }
  const auto tall = quilt_of(*field, {1, 3}, Interpolation::kQuadrilinear, 1);
  ASSERT_TRUE(tall.ok());
  EXPECT_NEAR(tall->pixels[2 * 12 * 16][0], quilt->pixels[0][0], 1e-6) << "the leftmost view is the lowest";
}

}  // namespace
}  // namespace tessera::client::light_field_test
