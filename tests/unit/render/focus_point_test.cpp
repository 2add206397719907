// Cameras that are focused on a place of the picture: as if its distance had been written.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "support/picture/render_image.h"
#include "support/picture/scene_file.h"

namespace tessera::test::focus_point {
namespace {

/// A wall with checks on it whose depth is 6 + x, seen from (0, 0, 0) along z.
std::vector<float> picture(const std::string& lens, const std::string& camera) {
  SceneJob job;
  job.settings.set_integrator("path");
  job.settings.set_max_depth(1);
  job.settings.set_spp(64);
  const auto file = load_scene_text(
      absl::StrCat(
          "film { width: 48 height: 32 filter { kind: BOX } } lights { distant { direction { z: 1 } "
          "irradiance { constant: 2 } } } textures { name: 'checks' checkerboard { even { constant { "
          "constant: 0.9 } } odd { constant { constant: 0.1 } } mapping { source: PLANAR "
          "texture_from_world { elements: [2,0,0,0, 0,2,0,0, 0,0,2,0, 0,0,0,1] } } } } materials { "
          "name: 'wall' diffuse { reflectance { texture: 'checks' } } } shapes { disk { radius: 30 } "
          "material: 'wall' world_from_object { elements: [1,0,0,0, 0,1,0,0, 1,0,-1,6, 0,0,0,1] } } "
          "camera { perspective { fov_degrees: 60 lens_radius: 0.4 ",
          lens, " } ", camera, " }"),
      job, render::supported_isas().front());
  EXPECT_TRUE(file.ok()) << file.status();
  return file.ok() ? render_image(*file).find("R")->values : std::vector<float>();
}

double mean_difference(const std::vector<float>& a, const std::vector<float>& b) {
  EXPECT_EQ(a.size(), b.size());
  double difference = 0, sum = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    difference += std::abs(a[i] - b[i]), sum += a[i] + b[i];
  return difference / sum;
}

/// Depth of the wall along (x, 0, 1).
double depth_along(double x) { return 6 / (1 - x); }

std::string at(double depth) { return absl::StrFormat("focal_distance: %.9g", depth); }

// The place three quarters of the way to the right edge, at y = 0: (0.875, 0.5).
constexpr const char* kPoint = "focus_point { x: 0.875 y: 0.5 } ";
const double kPlace = 0.75 * 1.5 * std::tan(M_PI / 6);

// Random numbers are the same, and distances equal but for their last digits: differences are those of rays
// that round to other sides of something. What is focused elsewhere differs by what checks are blurred.
constexpr double kSame = 1e-4, kOther = 1e-2;

TEST(FocusPoint, IsTheDepthOfWhatIsThere) {
  const std::vector<float> by_point = picture("", kPoint);
  EXPECT_LT(mean_difference(by_point, picture(at(depth_along(kPlace)), "")), kSame);
  EXPECT_GT(mean_difference(by_point, picture(at(5), "")), kOther);
}

TEST(FocusPoint, IsWhatADistortedFilmSeesThere) {
  const std::string distortion = "distortion { opencv { k1: -0.1 } } ";
  // r (1 + k1 r^2) = kPlace, by Newton's method.
  double r = kPlace;
  for (int i = 0; i < 20; ++i) r -= (r * (1 - 0.1 * r * r) - kPlace) / (1 - 0.3 * r * r);
  const std::vector<float> by_point = picture("", kPoint + distortion);
  EXPECT_LT(mean_difference(by_point, picture(at(depth_along(r)), distortion)), kSame);
  EXPECT_GT(mean_difference(by_point, picture(at(depth_along(kPlace)), distortion)), kOther);
}

TEST(FocusPoint, IsOnThePlaneOfATiltedLens) {
  // x sin(tilt) / f + z / D = 1 (docs/lenses.md).
  const std::string tilt = "tilt { y_degrees: 1 focal_length: 0.5 } ";
  const double depth = depth_along(kPlace), across = std::sin(M_PI / 180) / 0.5;
  const double distance = depth / (1 - across * depth * kPlace);
  ASSERT_GT(distance, 0);
  const std::vector<float> by_point = picture(tilt, kPoint);
  EXPECT_LT(mean_difference(by_point, picture(tilt + at(distance), "")), kSame);
  EXPECT_GT(mean_difference(by_point, picture(tilt + at(depth), "")), kOther);
}

}  // namespace
}  // namespace tessera::test::focus_point
