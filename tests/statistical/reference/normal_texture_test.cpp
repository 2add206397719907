// Normal maps that are not images.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "absl/strings/str_cat.h"
#include "statistical/reference/picture.h"

namespace tessera::test {
namespace {

/// A matt floor under a sun straight above, whose normal leans by 30 degrees as `texture` says.
std::string floor_with(const std::string& texture) {
  return absl::StrCat("textures { name: 'lean' ", texture, " } ", R"(
    materials { name: 'matt' diffuse { reflectance { constant { constant: 0.5 } } } normal_texture: 'lean' }
    shapes { disk { radius: 9 } material: 'matt' }
    lights { distant { direction { x: 0 y: 0 z: -1 } irradiance { constant: 2 } } }
    camera { orthographic { } world_from_camera { elements: [1,0,0,0, 0,-1,0,0, 0,0,-1,4, 0,0,0,1] } } )");
}

TEST(NormalTexture, BendsByAnyTexture) {
  // Light along the true normal meets the bent one under 30 degrees, whichever way that leans.
  PictureRequest request;
  request.max_depth = 1;
  request.spp = 64;
  // (0.5, 0, cos 30), in the range from 0 to 1.
  const std::string leaning = "{ rgb { r: 0.75 g: 0.5 b: 0.9330127 } }",
                    straight = "{ rgb { r: 0.5 g: 0.5 b: 1 } }";
  const double whole = 2 * 0.5 / std::numbers::pi, bent = whole * std::cos(std::numbers::pi / 6);
  request.scene = floor_with("constant " + straight);
  expect_value(measure_picture(request), whole, 1e-5);
  request.scene = floor_with("constant " + leaning);
  expect_value(measure_picture(request), bent, 1e-5);
  // A mixture of both, half and half of the vectors.
  request.scene = floor_with(absl::StrCat("mix { a { constant ", leaning, " } b { constant ", straight,
                                          " } amount { constant: 0.5 } }"));
  expect_value(measure_picture(request), whole * std::cos(std::numbers::pi / 12), 1e-5);
}

}  // namespace
}  // namespace tessera::test
