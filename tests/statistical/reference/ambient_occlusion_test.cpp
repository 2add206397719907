// Ambient occlusion against what can be said in closed form.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <string>

#include "absl/strings/str_cat.h"
#include "support/picture/render_image.h"

namespace tessera::test::ambient_occlusion {  // apart from tests that are compiled with these
namespace {

constexpr int kSide = 32, kSamples = 64;

/// The floor y = 0, a disk of this radius one metre above it, and half a metre above the floor a camera that
/// sees a hundredth of a millimetre of it, straight below.
std::string scene(double disk_radius, double distance) {
  return absl::StrCat(
      "camera { orthographic {} screen_window: [-1e-5, 1e-5, -1e-5, 1e-5]"
      " world_from_camera { elements: [1,0,0,0, 0,0,-1,0.5, 0,1,0,0, 0,0,0,1] } }"
      " film { width: ",
      kSide, " height: ", kSide, " filter { kind: BOX } }", " settings { integrator: 'ao' spp: ", kSamples,
      " sampler: SAMPLER_INDEPENDENT ao { distance: ", distance, " } }",
      " shapes { disk { radius: 10 } world_from_object { elements: [1,0,0,0, 0,0,1,0, 0,-1,0,0, 0,0,0,1] } "
      "}",
      " shapes { disk { radius: ", disk_radius,
      " } world_from_object { elements: [1,0,0,0, 0,0,1,1, 0,-1,0,0, 0,0,0,1] } }");
}

/// `open`: the share of the sky that is seen.
void expect_open(double open, double disk_radius, double distance) {
  SCOPED_TRACE(absl::StrCat("disk of radius ", disk_radius, ", distance ", distance));
  const auto file = load_scene_text(scene(disk_radius, distance), {}, render::supported_isas().front());
  ASSERT_TRUE(file.ok()) << file.status();
  const client::Image image = render_image(*file);
  const std::vector<float>& values = image.find("G")->values;
  ASSERT_EQ(values.size(), std::size_t{kSide * kSide});
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  // Each sample is 1 with probability `open`, else 0. Six standard errors: one failure in 5e8.
  const double error = std::sqrt(open * (1 - open) / (kSide * kSide * kSamples));
  EXPECT_NEAR(mean, open, 6 * error + 1e-6);
}

TEST(AmbientOcclusion, IsTheCosineWeightedShareOfTheSky) {
  // A disk above hides its form factor, r^2 / (r^2 + h^2) [Howell 2010, B-13].
  expect_open(1.0 / 2, 1, 0);
  expect_open(1.0 / 5, 2, 0);
  expect_open(1e6 / (1e6 + 1), 1e-3, 0);
}

TEST(AmbientOcclusion, DoesNotSeeBeyondItsDistance) {
  expect_open(1, 1, 0.9);
  // A whole ceiling hides the directions in which it is nearer: the cosine is above 1 / distance.
  expect_open(1.0 / 4, 10, 2);
  expect_open(1.0 / 9, 10, 3);
}

}  // namespace
}  // namespace tessera::test::ambient_occlusion
