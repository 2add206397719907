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

/// A floor of this material under a sun that stands 10 degrees off the zenith, towards x.
std::string floor_of(const std::string& material) {
  return absl::StrCat(R"(
    textures { name: 'lean' constant { rgb { r: 0.6294095 g: 0.5 b: 0.9829629 } } }
    shapes { disk { radius: 9 } material: 'm' }
    lights { distant { direction { x: -0.1736482 y: 0 z: -0.9848078 } irradiance { constant: 2 } } }
    camera { orthographic { } world_from_camera { elements: [1,0,0,0, 0,-1,0,0, 0,0,-1,4, 0,0,0,1] } }
    materials { name: 'm' )",
                      material, " }");
}

Picture picture_of(const std::string& material) {
  PictureRequest request;
  request.max_depth = 1;
  request.spp = 64;
  request.scene = floor_of(material);
  // (sin 15, 0, cos 15) in the range from 0 to 1, as an image.
  constexpr float kLeaning[3] = {0.6294095f, 0.5f, 0.9829629f};
  std::string image = "PF\n1 1\n-1.0\n";
  image.append(reinterpret_cast<const char*>(kLeaning), sizeof kLeaning);
  request.blobs = {{"lean", image}};
  return measure_picture(request);
}

double brightness_of(const std::string& material) { return picture_of(material).whole(0).mean; }

TEST(NormalTexture, OfACoatBendsTheCoatAlone) {
  // A coat of index 1.5 over nothing, and a black dielectric of the same index and roughness. The tangents of
  // a disk go round, so that normals lean every way, and lobes are seen from 5 to 20 degrees off their peak,
  // where light between the facets, which a coat does not give back, is up to 0.4 % of them.
  constexpr double kBetween = 5e-3;
  constexpr const char* kMap =
      " clearcoat_normal_map { image { digest: 'lean' path: 'lean.pfm' } encoding: LINEAR }";
  const auto coat = [](const std::string& more) {
    return absl::StrCat(
        "gltf { base_color { constant { constant: 0 } } metallic { constant: 0 } specular { constant: 0 } "
        "clearcoat { constant: 1 } clearcoat_roughness { constant: 0.4 }",
        more, " }");
  };
  constexpr const char* kPlain =
      "gltf { base_color { constant { constant: 0 } } metallic { constant: 0 } roughness { constant: 0.4 } }";
  const double straight = brightness_of(kPlain),
               leaning = brightness_of(absl::StrCat(kPlain, " normal_texture: 'lean'"));
  EXPECT_GT(std::abs(leaning / straight - 1), 0.1);
  EXPECT_NEAR(brightness_of(coat("")) / straight, 1, kBetween);
  EXPECT_NEAR(brightness_of(coat(kMap)) / leaning, 1, kBetween);
  // The base's map does not bend the coat.
  EXPECT_NEAR(brightness_of(absl::StrCat(coat(""), " normal_texture: 'lean'")) / straight, 1, kBetween);
  EXPECT_NEAR(brightness_of(absl::StrCat(coat(kMap), " normal_texture: 'lean'")) / leaning, 1, kBetween);
}

TEST(NormalTexture, OfDirectionsTurnsTheAnisotropy) {
  const auto metal = [](const std::string& more) {
    return picture_of(
        absl::StrCat("gltf { roughness { constant: 0.4 } anisotropy { constant: 0.8 } ", more, " }"));
  };
  // Blocks are compared, as the tangents of a disk go round. A block has 4096 samples, which vary by less
  // than a half: six standard errors of a difference of two are below 0.07.
  const auto largest_difference = [](const Picture& a, const Picture& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.values.size(); ++i)
      largest = std::max(largest, std::abs(a.values[i].mean / b.values[i].mean - 1));
    return largest;
  };
  constexpr double kSame = 0.07, kOther = 0.15;
  // (cos 60, sin 60), of any length.
  constexpr const char* kSixty = "anisotropy_direction { constant { rgb { r: 0.625 g: 0.7165064 b: 1 } } }";
  const Picture straight = metal(""), turned = metal("anisotropy_rotation: 60");
  EXPECT_GT(largest_difference(turned, straight), kOther);
  EXPECT_LT(largest_difference(metal(kSixty), turned), kSame);
  EXPECT_LT(largest_difference(metal(absl::StrCat(kSixty, " anisotropy_rotation: -60")), straight), kSame);
}

}  // namespace
}  // namespace tessera::test
