// Synthetic apertures and depth from focus.
#include "light_field/refocus.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "light_field/focal_stack.h"
#include "unit/client/light_field/synthetic_set.h"

namespace tessera::client::light_field_test {
namespace {

using light_field::Aperture;
using ::testing::HasSubstr;

constexpr ViewSize kSmall{48, 48};

CameraGrid test_grid() { return grid_plan(5, 0.1, 5, kSmall).arrangement.grids[0]; }

double sum_of(const std::vector<std::pair<std::uint32_t, float>>& weights) {
  return std::accumulate(weights.begin(), weights.end(), 0.0,
                         [](double sum, const auto& each) { return sum + each.second; });
}

TEST(Apertures, WeighCameras) {
  const CameraGrid grid = test_grid();
  EXPECT_NEAR(light_field::largest_radius(grid), 0.2, 1e-12);
  const auto pinhole = camera_weights(grid, {}).value();
  ASSERT_EQ(pinhole.size(), 1u);
  EXPECT_EQ(pinhole[0].first, 12u) << "the middle one of five times five";
  const auto between = camera_weights(grid, {.x = 0.05, .y = 0.1}).value();
  ASSERT_EQ(between.size(), 2u) << "of the row above";
  EXPECT_EQ(between[0].first, 7u);
  EXPECT_NEAR(between[0].second, 0.5, 1e-6);
  const auto round = camera_weights(grid, {.radius = 0.2}).value();
  EXPECT_NEAR(sum_of(round), 1, 1e-5);
  EXPECT_EQ(round.size(), 21u + 4) << "corners have a share of the points beside them";
  // A triangle that points up has more of the lower rows.
  const auto triangle = camera_weights(grid, {.radius = 0.2, .blades = 3, .blade_degrees = 90}).value();
  double above = 0, below = 0;
  for (const auto& [view, weight] : triangle) {
    if (view < 10) above += weight;
    if (view >= 15) below += weight;
  }
  EXPECT_GT(below, above);
  EXPECT_THAT(std::string(camera_weights(grid, {.x = 0.3}).status().message()),
              HasSubstr("beside the cameras"));
}

TEST(Refocus, OfAPinholeIsTheViewItself) {
  const support::TempDir directory;
  const Shader shade = plane(5, 0, waves);
  const CapturePlan plan = grid_plan(5, 0.1, 5, kSmall);
  write_set(directory / "a.lf", plan, kSmall, shade);
  const auto field = open(directory / "a.lf");
  const auto picture = refocus(*field, {}, {.distance = 3}, 2);
  ASSERT_TRUE(picture.ok()) << picture.status();
  const Image truth = shaded(plan.cameras[12], kSmall.width, kSmall.height, shade);
  for (std::size_t i = 0; i < truth.pixel_count(); ++i)
    EXPECT_NEAR(picture->pixels[i][0], truth.channels[0].values[i], 2e-5);
}

/// A spot on the axis at this height, a Gaussian of this width, on black.
Shader spot(double height, double width) {
  return plane(height, 0, [=](const V3d& p) { return std::exp(-(p.x * p.x + p.y * p.y) / (width * width)); });
}

TEST(Refocus, APointIsSharpWhereItIsAndBlurredElsewhere) {
  const support::TempDir directory;
  write_set(directory / "a.lf", grid_plan(5, 0.1, 5, kSmall), kSmall, spot(6, 0.25));
  const auto field = open(directory / "a.lf");
  const auto middle = [&](double distance) {
    const auto picture = refocus(*field, {.radius = 0.2}, {.distance = distance}, 1);
    EXPECT_TRUE(picture.ok());
    return picture->pixels[24 * 48 + 24][0];
  };
  const auto pinhole = refocus(*field, {}, {.distance = 6}, 1);
  // Pixels of 2 tan(20 degrees) 6 / 48 = 0.091; the peak's second derivative is 2 / 0.25^2, and interpolation
  // between pixels errs by 2 * 0.091^2 / 8 * 32 at most.
  EXPECT_NEAR(middle(6), pinhole->pixels[24 * 48 + 24][0], 0.07);
  // In focus at 3, views through the aperture's edge see the spot 0.2 (6 - 3) / 3 = 0.2 aside.
  EXPECT_LT(middle(3), 0.9 * middle(6));
  EXPECT_LT(middle(2), middle(3));
}

TEST(Refocus, ATiltedPlaneIsSharpAsAWhole) {
  const support::TempDir directory;
  const Shader shade = plane(5, 0.4, waves);
  write_set(directory / "a.lf", grid_plan(5, 0.1, 5, kSmall), kSmall, shade);
  const auto field = open(directory / "a.lf");
  const auto eye = camera_of_grid(field->manifest(), test_grid(), 0, 0);
  const auto tilted = refocus(*field, {.radius = 0.2}, {.distance = 5, .slope_x = 0.4}, 1);
  ASSERT_TRUE(tilted.ok());
  // Pixels at the far end lie 2 tan(20 degrees) (5 + 0.4 * 0.2) / 48 / (1 - 0.4 * 0.404)^2 = 0.11 apart, of
  // the outermost cameras.
  EXPECT_LT(worst_error(*tilted, eye, shade), 2 * 0.11 * 0.11 / 8 * 0.15 * 16 + 1e-5);
}

TEST(FocalStacks, FindTheDepth) {
  const support::TempDir directory;
  const Shader shade = plane(5, 0, waves);
  write_set(directory / "a.lf", grid_plan(5, 0.15, 4, kSmall), kSmall, shade);
  const auto field = open(directory / "a.lf");
  const light_field::FocalStackOptions options{.near = 3, .far = 12, .planes = 16};
  const auto stack = focal_stack(*field, {.radius = 0.3}, options);
  ASSERT_TRUE(stack.ok()) << stack.status();
  // Inverse depths are (1/3 - 1/12) / 15 apart, and the plane is found but for one of these. Borders are seen
  // by few views.
  const double step = 0.25 / 15;
  int far_off = 0;
  for (std::size_t y = 8; y < 40; ++y) {
    for (std::size_t x = 8; x < 40; ++x) far_off += std::abs(1 / stack->depths[y * 48 + x] - 0.2) > step;
  }
  // Where both waves are at their tops, a square of pixels tells nothing: few of them.
  EXPECT_LT(far_off, 32 * 32 / 20);
  EXPECT_FALSE(focal_stack(*field, {}, options).ok()) << "one camera alone";
  EXPECT_FALSE(focal_stack(*field, {.radius = 0.3}, {.near = 3, .far = 2}).ok());
}

}  // namespace
}  // namespace tessera::client::light_field_test
