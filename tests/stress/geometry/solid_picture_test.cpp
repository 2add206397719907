// Solids in pictures: of glass and as borders of media, mirrored and moving, in light in which nothing that
// absorbs nothing is seen; and half-spaces, of which nothing ends.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "support/picture/render_image.h"

namespace tessera::test {
namespace solid_picture {

constexpr const char* kClosed[] = {
    "box { low: [-1, -0.8, -0.7] high: [1, 0.8, 0.7] }",
    "polyhedron { vertices: [-1,-1,-1, 1,-1,-1, 0,1.2,-1, 0,0,1.3] }",
    "polyhedron { planes: [1,1,1,1, -1,1,1,1, 1,-1,1,1, 1,1,-1,1, -1,-1,1,1, "
    "-1,1,-1,1, 1,-1,-1,1, -1,-1,-1,1] }",
    "cone { radius: 1 height: 1.5 capped: true }",
    "cone { radius: 0.5 top_radius: 1 height: 1 capped: true }",
    "cylinder { radius: 0.8 z_min: -0.9 z_max: 0.9 capped: true }",
    "torus { major_radius: 0.8 minor_radius: 0.35 }",
    "ellipsoid { radii: [1, 0.6, 0.8] }",
    "csg { operation: DIFFERENCE parts { solid { sphere { radius: 1 } } } parts { "
    "solid { box { low: [-2, 0.2, -2] high: [2, 2, 0] } } } parts { solid { torus { "
    "major_radius: 0.8 minor_radius: 0.35 } } } }"};

/// Turned, sheared, in front of the camera.
constexpr const char* kPlaced =
    " world_from_object { elements: [0.8,0.1,0.5,0, 0,1,-0.3,0, -0.5,0.2,0.9,5, 0,0,0,1] } ";
constexpr const char* kMirrored =
    " world_from_object { elements: [-0.8,0.1,0.5,0, 0,1,-0.3,0, 0.5,0.2,0.9,5, 0,0,0,1] } ";
constexpr const char* kMoving =
    " world_from_object { elements: [0.8,0.1,0.5,0, 0,1,-0.3,0, -0.5,0.2,0.9,5, 0,0,0,1] }"
    " world_from_object_end { elements: [0.8,0.1,0.5,0.4, 0,1,-0.3,0.2, -0.5,0.2,0.9,5, 0,0,0,1] } ";

absl::StatusOr<LoadedFile> load(const std::string& scene, const std::string& integrator, std::uint32_t spp) {
  SceneJob job;
  job.settings.set_integrator(integrator);
  job.settings.set_spp(spp);
  job.settings.set_max_depth(500);
  return load_scene_text(
      absl::StrCat(
          "camera { perspective { fov_degrees: 40 } } film { width: 32 height: 32 filter { kind: BOX } } "
          "lights { infinite { radiance { constant: 1 } } } materials { name: 'glass' dielectric { eta { "
          "constant: 1.5 } } } materials { name: 'air' interface {} } media { name: 'haze' extinction { "
          "constant { constant: 1 } } albedo { constant { constant: 1 } } } ",
          scene),
      job, render::supported_isas().front());
}

std::vector<double> pixels_of(const std::string& scene, const std::string& integrator, std::uint32_t spp) {
  const auto file = load(scene, integrator, spp);
  EXPECT_TRUE(file.ok()) << file.status();
  if (!file.ok()) return {};
  const client::Image image = render_image(*file);
  const client::Channel* green = image.find("G");
  return green == nullptr ? std::vector<double>()
                          : std::vector<double>(green->values.begin(), green->values.end());
}

double mean(const std::vector<double>& pixels) {
  double sum = 0;
  for (const double p : pixels) sum += p;
  return sum / static_cast<double>(pixels.size());
}

class Solids : public testing::TestWithParam<const char*> {};

/// Light that is reflected inside, forever in a solid with corners at right angles, has weights of all but 1:
/// roulette takes no notice of them, and a path that ends at the depth limit is one in many.
TEST_P(Solids, OfGlassVanishInWhiteLight) {
  for (const char* const placed : {kPlaced, kMirrored, kMoving}) {
    const std::vector<double> pixels =
        pixels_of(absl::StrCat("shapes { ", GetParam(), placed, " material: 'glass' }"), "path", 64);
    ASSERT_EQ(pixels.size(), 1024u);
    EXPECT_NEAR(mean(pixels), 1, 1e-3) << placed;
  }
}

TEST_P(Solids, HoldMediaThatVanishInWhiteLight) {
  for (const char* const placed : {kPlaced, kMirrored, kMoving}) {
    const std::vector<double> pixels =
        pixels_of(absl::StrCat("shapes { ", GetParam(), placed, " material: 'air' interior_medium: 'haze' }"),
                  "volpath", 64);
    ASSERT_EQ(pixels.size(), 1024u);
    EXPECT_NEAR(mean(pixels), 1, 2e-3) << placed;
  }
}

/// A medium that absorbs tells that there is a medium at all, and on the inner side of a mirrored border.
TEST_P(Solids, HoldMediaWithin) {
  const std::string haze = "media { name: 'soot' extinction { constant { constant: 1 } } } ";
  const auto share = [&](const char* placed) {
    return mean(pixels_of(
        absl::StrCat(haze, "shapes { ", GetParam(), placed, " material: 'air' interior_medium: 'soot' }"),
        "volpath", 64));
  };
  const double straight = share(kPlaced);
  EXPECT_GT(straight, 0.5);
  EXPECT_LT(straight, 0.98);
  // The outline of the mirrored one is another, but of like size; outside of it the whole picture would be
  // dark.
  EXPECT_NEAR(share(kMirrored), straight, 0.1);
}

/// A shape that emits becomes triangles, even where it emits nothing: the same picture, by the same
/// parameters.
TEST(FlatShapes, LookLikeTheirTriangles) {
  const std::string squares =
      "textures { name: 'squares' checkerboard { even { constant { constant: 0.9 } } odd { constant { "
      "constant: 0.1 } "
      "} mapping { scale_u: 7 scale_v: 4 } } } materials { name: 'squares' diffuse { reflectance { texture: "
      "'squares' "
      "} } } ";
  for (const char* const shape :
       {kClosed[0], kClosed[1], kClosed[2],
        "polygon { corners: [-1,-1,0, 1,-1,0.2, 0.9,1,0.19, 0,0,0.1, -0.9,1,0.01] }"}) {
    for (const char* const placed : {kPlaced, kMirrored}) {
      const auto picture = [&](const char* light) {
        return pixels_of(absl::StrCat(squares, "shapes { ", shape, placed,
                                      " material: 'squares' uv_transform: [1, "
                                      "0.5, 0.1, 0, 1, 0.2] ",
                                      light, " }"),
                         "direct", 16);
      };
      const std::vector<double> own = picture(""),
                                triangles = picture("area_light { radiance { constant: 0 } }");
      ASSERT_EQ(own.size(), triangles.size());
      int differ = 0;
      for (std::size_t i = 0; i < own.size(); ++i) differ += std::abs(own[i] - triangles[i]) > 1e-3;
      // Samples on edges and on borders of squares, within rounding.
      EXPECT_LT(differ, 20) << shape << placed;
      EXPECT_LT(mean(own), 0.97);
    }
  }
}

std::string title_of(const testing::TestParamInfo<const char*>& info) {
  const std::string text = info.param;
  return absl::StrCat(text.substr(0, text.find(' ')), info.index);
}
INSTANTIATE_TEST_SUITE_P(All, Solids, testing::ValuesIn(kClosed), title_of);

/// A floor with a ball on it, below the camera.
std::string on_floor(const std::string& floor) {
  return absl::StrCat(
      "lights { point { position { x: 1 y: 2 z: 3 } intensity { constant: 30 } } } ",
      "shapes { sphere { radius: 0.5 } world_from_object { elements: [1,0,0,0, 0,1,0,-0.5, 0,0,1,4, "
      "0,0,0,1] } } ",
      floor);
}
/// Its normal is up: z of the object to y of the world, at y = -1.
constexpr const char* kFloor = " world_from_object { elements: [1,0,0,0, 0,0,1,-1, 0,-1,0,0, 0,0,0,1] } }";

TEST(HalfSpaces, LookLikeADiskThatIsAlmostAsLarge) {
  const double disk =
      mean(pixels_of(on_floor(absl::StrCat("shapes { disk { radius: 1e5 }", kFloor)), "path", 64));
  const double plane = mean(pixels_of(on_floor(absl::StrCat("shapes { half_space {}", kFloor)), "path", 64));
  const double instance = mean(
      pixels_of(on_floor(absl::StrCat("objects { name: 'o' shapes { half_space { height: 0.5 } ", kFloor,
                                      " } instances { object: 'o' world_from_instance { elements: [1,0,0,3, "
                                      "0,1,0,-0.5, 0,0,1,0, 0,0,0,1] } }")),
                "path", 64));
  const double moving = mean(pixels_of(
      on_floor(
          "shapes { half_space {} world_from_object { elements: [1,0,0,0, 0,0,1,-1, 0,-1,0,0, 0,0,0,1] } "
          "world_from_object_end { elements: [1,0,0,2, 0,0,1,-1, 0,-1,0,3, 0,0,0,1] } }"),
      "path", 64));
  // Both are of one sampling sequence; roundings choose other paths now and then.
  EXPECT_NEAR(plane, disk, 0.003 * disk);
  EXPECT_NEAR(instance, disk, 0.003 * disk);
  EXPECT_NEAR(moving, disk, 0.003 * disk);
}

TEST(HalfSpaces, AreRefusedWhereLightAtInfinityIsStarted) {
  const auto file = load(absl::StrCat("shapes { half_space {}", kFloor), "light", 4);
  EXPECT_THAT(std::string(file.status().message()), testing::HasSubstr("falls on all of a half-space"));
}

TEST(HalfSpaces, AreRefusedWhereFloatsEnd) {
  const auto file = load(
      "objects { name: 'o' shapes { half_space {} world_from_object { elements: [1e8,0,0,0, 0,1e8,0,0, "
      "0,0,1e8,0, "
      "0,0,0,1] } } } instances { object: 'o' world_from_instance { elements: [1e3,0,0,0, 0,1e3,0,0, "
      "0,0,1e3,0, "
      "0,0,0,1] } }",
      "path", 4);
  EXPECT_THAT(std::string(file.status().message()), testing::HasSubstr("than 32-bit floats hold"));
}

}  // namespace solid_picture
}  // namespace tessera::test
