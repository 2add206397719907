// Media and surfaces that light passes without being scattered, as whole pictures: closed forms, and scenes
// that must look the same.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "statistical/reference/picture.h"
#include "wire/volume_blob.h"

namespace tessera::test {
namespace {

TestBlobs media_blobs() {
  const std::vector<float> even(3 * 4 * 2, 1.0f);
  std::vector<float> uneven;
  for (int i = 0; i < 6 * 5 * 4; ++i) uneven.push_back(i % 3 == 0 ? 0.0f : 0.1f * static_cast<float>(i % 11));
  return {{"even", wire::encode_volume({3, 4, 2, 1, even})},
          {"uneven", wire::encode_volume({6, 5, 4, 1, uneven})}};
}

// At (0, -4, 1), looking along +y; z is up.
constexpr const char* kCamera = R"( camera { perspective { fov_degrees: 35 }
  world_from_camera { elements: [1,0,0,0, 0,0,1,-4, 0,1,0,1, 0,0,0,1] } } )";
// A cube about (0, 0, 1) that holds the balls below.
constexpr const char* kGridPlace =
    "world_from_grid { elements: [3,0,0,-1.5, 0,3,0,-1.5, 0,0,3,-0.5, 0,0,0,1] }";
constexpr const char* kNull = " materials { name: 'null' interface { } } ";

std::string medium(const std::string& extinction, const std::string& more) {
  return absl::StrCat(" media { name: 'm' extinction { ", extinction, " } ", more, " } ");
}
std::string in_grid(const char* blob) {
  return absl::StrCat("grid { blob { digest: '", blob, "' } ", kGridPlace, " }");
}
constexpr const char* kGrey = "constant { constant: 1.5 }";
constexpr const char* kColoured = "constant { rgb { r: 0.5 g: 1.5 b: 3 } }";
constexpr const char* kWhite = "albedo { constant { constant: 1 } }";

/// Makes a ball of radius 1.2 about (0, 0, 1), filled with 'm'.
std::string ball(const std::string& material) {
  return absl::StrCat(
      " shapes { sphere { radius: 1.2 } material: '", material,
      "' interior_medium: 'm' world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,1,1, 0,0,0,1] } } ");
}

Picture volpath(const std::string& scene, std::uint32_t max_depth = 4, std::uint32_t spp = 512) {
  PictureRequest request;
  request.scene = scene;
  request.integrator = "volpath";
  request.max_depth = max_depth;
  request.spp = spp;
  request.blobs = media_blobs();
  return measure_picture(request);
}
Picture path(const std::string& scene, std::uint32_t max_depth = 4, std::uint32_t spp = 512) {
  PictureRequest request;
  request.scene = scene;
  request.max_depth = max_depth;
  request.spp = spp;
  request.blobs = media_blobs();
  return measure_picture(request);
}

TEST(Media, WhiteFurnace) {
  const std::string rest = absl::StrCat(kNull, kSky, kCamera, ball("null"));
  for (const std::string& filling : {medium(kGrey, kWhite), medium(kGrey, absl::StrCat(kWhite, " g: 0.8")),
                                     medium(kColoured, absl::StrCat(kWhite, " g: -0.3")),
                                     medium(in_grid("uneven"), absl::StrCat(kWhite, " scale: 3"))}) {
    SCOPED_TRACE(filling);
    expect_value(volpath(filling + rest, 1000), 1);
  }
}

TEST(Media, WhiteFurnaceBehindGlass) {
  // Refraction keeps radiance too, once the light is out again.
  // Smooth, as microfacet models without multiple scattering lose a little.
  const std::string smooth = "materials { name: 'glass' dielectric { eta { constant: 1.4 } } } ";
  expect_value(volpath(absl::StrCat(medium(kGrey, kWhite), smooth, kSky, kCamera, ball("glass")), 2000), 1);
}

TEST(Media, WhiteFurnaceOfALamp) {
  // All around is a lamp of radiance 1, found by sampling it and by chance.
  const std::string lamp =
      R"( materials { name: 'black' diffuse { reflectance { constant { constant: 0 } } } }
    shapes { sphere { radius: 9 } material: 'black' area_light { radiance { constant: 1 } }
      reverse_orientation: true } )";
  const std::string white =
      "materials { name: 'white' diffuse { reflectance { constant { constant: 1 } } } } "
      "shapes { disk { radius: 1 } material: 'white' } ";
  expect_value(volpath(absl::StrCat(medium(kGrey, kWhite), kNull, lamp, white, kCamera, ball("null")), 1000),
               1);
}

/// The medium between the planes z = 0.5 and z = 1.7, seen from above and before a sky of radiance 1.
std::string slab() {
  return absl::StrCat(kNull, kSky, R"(
    shapes { disk { radius: 9 height: 1.7 } material: 'null' interior_medium: 'm' }
    shapes { disk { radius: 9 height: 0.5 } material: 'null' exterior_medium: 'm' }
    camera { orthographic { } world_from_camera { elements: [1,0,0,0, 0,-1,0,0, 0,0,-1,4, 0,0,0,1] } } )");
}

TEST(Media, AbsorptionAndEmissionOfASlab) {
  const double d = 1.2, sigma = 1.5;
  expect_value(volpath(medium(kGrey, "") + slab(), 4), std::exp(-sigma * d));
  const double depth = 0.7 * d;
  expect_value(
      volpath(medium("constant { constant: 0.7 }", "emission { constant { constant: 2 } }") + slab(), 4),
      std::exp(-depth) + 2 * (1 - std::exp(-depth)));
  // A grid ends at its bounds, here at z = -0.5 and 2.5, and leaves nothing out within.
  const std::string wide_grid =
      "grid { blob { digest: 'even' } world_from_grid { elements: [9,0,0,-4.5, 0,9,0,-4.5, 0,0,3,-0.5, "
      "0,0,0,1] } }";
  expect_value(volpath(absl::StrCat(medium(wide_grid, "scale: 1.5"), slab()), 4), std::exp(-sigma * d));
  const std::string low_grid =
      "grid { blob { digest: 'even' } world_from_grid { elements: [9,0,0,-4.5, 0,9,0,-4.5, 0,0,1,0, 0,0,0,1] "
      "} }";
  expect_value(volpath(absl::StrCat(medium(low_grid, "scale: 1.5"), slab()), 4), std::exp(-sigma * 0.5));
}

TEST(Media, EndsAtItsBounds) {
  // From z = 0.5, where the slab begins, to 1.2; across, all of the picture.
  const std::string bounds = "world_from_bounds { elements: [9,0,0,-4.5, 0,9,0,-4.5, 0,0,1.2,0, 0,0,0,1] } ";
  expect_value(volpath(medium(kGrey, bounds) + slab(), 4), std::exp(-1.5 * 0.7));
  // A grid that is shorter reaches on to them with its outermost samples.
  const std::string short_grid =
      "grid { blob { digest: 'even' } world_from_grid { elements: [9,0,0,-4.5, 0,9,0,-4.5, 0,0,0.1,0.8, "
      "0,0,0,1] } }";
  expect_value(volpath(medium(short_grid, absl::StrCat("scale: 1.5 ", bounds)) + slab(), 4),
               std::exp(-1.5 * 0.7));
  // Turned by 45 degrees about x they are not a box along the axes: the picture is brighter where they are
  // shorter.
  const std::string cube =
      "world_from_bounds { elements: [9,0,0,-4.5, 0,0.5,-0.5,0, 0,0.5,0.5,0.6, 0,0,0,1] } ";
  // At y from -0.5 to 0.5 the way through is 1 - 2 |y|, at z from 0.6 to 1.6; the picture is y from -1 to 1.
  const double through = (1 - std::exp(-1.5)) / 1.5;
  expect_value(Picture{{volpath(medium(kGrey, cube) + slab(), 4).whole(0)}}, (1 + through) / 2);
}

TEST(Media, CameraWithinAMedium) {
  // From the middle of the slab.
  std::string scene = medium(kGrey, "") + slab();
  scene.replace(scene.find("-1,4,"), 5, "-1,1,");
  scene.replace(scene.find("orthographic { }"), 16, "orthographic { } medium: 'm'");
  expect_value(volpath(scene, 4), std::exp(-1.5 * 0.5));
}

/// A floor, a lamp, a matt ball beside.
constexpr const char* kRoom = R"(
  materials { name: 'matt' diffuse { reflectance { constant { rgb { r: 0.7 g: 0.5 b: 0.3 } } } } }
  shapes { disk { radius: 4 } material: 'matt' }
  shapes { sphere { radius: 0.4 } material: 'matt'
    world_from_object { elements: [1,0,0,1.1, 0,1,0,-1, 0,0,1,0.4, 0,0,0,1] } }
  shapes { disk { radius: 0.6 } reverse_orientation: true area_light { radiance { constant: 8 } }
           world_from_object { elements: [1,0,0,-0.4, 0,1,0,-0.2, 0,0,1,3, 0,0,0,1] } }
  lights { point { position { x: 2 y: -2 z: 2 } intensity { constant: 3 } } } )";

TEST(Media, EvenGridsAreHomogeneous) {
  const std::string rest = absl::StrCat(kNull, kRoom, kCamera, ball("null"));
  const std::string more =
      "albedo { constant { rgb { r: 0.9 g: 0.6 b: 0.3 } } } g: 0.4 emission { constant { rgb { r: 0.1 g: 0 "
      "b: 0.3 } } } scale: 1.5";
  expect_same(volpath(medium("constant { constant: 1 }", more) + rest, 6),
              volpath(medium(in_grid("even"), more) + rest, 6));
}

TEST(Media, CameraWithinAMediumSeesTheSameThroughAGrid) {
  const std::string camera = R"( camera { perspective { fov_degrees: 70 } medium: 'm'
    world_from_camera { elements: [1,0,0,0.1, 0,0,1,-0.3, 0,1,0,1, 0,0,0,1] } } )";
  const std::string rest = absl::StrCat(kNull, kRoom, camera, ball("null"));
  const std::string more = "albedo { constant { constant: 0.7 } } scale: 0.6";
  expect_same(volpath(medium("constant { constant: 1 }", more) + rest, 6),
              volpath(medium(in_grid("even"), more) + rest, 6));
}

TEST(Passing, VolpathIsPathWithoutMedia) {
  const std::string scene = absl::StrCat(kRoom, kCamera);
  expect_same(path(scene), volpath(scene));
}

TEST(Passing, NullInterfacesAreNotSeen) {
  const std::string scene = absl::StrCat(kRoom, kCamera);
  const std::string nothing = absl::StrCat(kNull, R"(
    shapes { sphere { radius: 1 } material: 'null'
      world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,1,1, 0,0,0,1] } }
    shapes { sphere { radius: 1.2 } material: 'null'
      world_from_object { elements: [1,0,0,0.4, 0,1,0,0, 0,0,1,1, 0,0,0,1] } } )");
  expect_same(path(scene), volpath(scene + nothing));
  // The same medium on both sides is no border, and thin air no medium.
  const std::string thin = absl::StrCat(nothing, medium("constant { constant: 0 }", ""), ball("null"));
  expect_same(path(scene), volpath(scene + thin));
}

TEST(Passing, SheetsDimAPointLight) {
  const std::string floor =
      R"( materials { name: 'matt' diffuse { reflectance { constant { constant: 0.5 } } } }
    shapes { disk { radius: 4 } material: 'matt' } )";
  const auto light = [](double intensity) {
    return absl::StrCat(" lights { point { position { x: 0.3 y: 0.2 z: 3 } intensity { constant: ", intensity,
                        " } } } ");
  };
  // Two sheets of opacity 0.3, and a slab that absorbs; all above the camera.
  const std::string sheets =
      R"( materials { name: 'sheet' diffuse { reflectance { constant { constant: 0 } } }
        opacity { constant: 0.3 } }
    shapes { disk { radius: 9 height: 2 } material: 'sheet' }
    shapes { disk { radius: 9 height: 2.2 } material: 'sheet' } )";
  expect_same(path(absl::StrCat(floor, kCamera, light(5 * 0.7 * 0.7)), 1),
              volpath(absl::StrCat(floor, kCamera, light(5), sheets), 1));
}

TEST(Passing, OpacityAndThinGlassInBothIntegrators) {
  // Passing costs "path" an event and "volpath" none; with many allowed, both see all the light there is.
  for (const char* material :
       {"diffuse { reflectance { constant { constant: 0.6 } } } opacity { constant: 0.4 }",
        "thin_dielectric { eta { constant: 1.5 } transmission_tint { constant { rgb { r: 0.9 g: 0.6 b: 0.3 } "
        "} } passes_straight: true }",
        "thin_dielectric { eta { constant: 1.5 } transmission_tint { constant { constant: 0.5 } } "
        "passes_straight: true } opacity { constant: 0.6 }",
        "conductor { reflectance { constant { constant: 0.7 } } roughness { u { constant: 0.3 } v { "
        "constant: 0.3 } } } opacity { texture: 'checks' }"}) {
    SCOPED_TRACE(material);
    const std::string scene = absl::StrCat(kRoom, kCamera, kSky, R"(
      textures { name: 'checks' checkerboard { even { constant { constant: 0.9 } }
        odd { constant { constant: 0.2 } } mapping { scale_u: 8 scale_v: 4 } } }
      materials { name: 'veil' )",
                                           material, R"( }
      shapes { sphere { radius: 0.9 } material: 'veil'
        world_from_object { elements: [1,0,0,-0.3, 0,1,0,0, 0,0,1,1, 0,0,0,1] } } )");
    // "path" cannot sample the point light through glass, so there is none.
    std::string without_point = scene;
    without_point.erase(
        without_point.find("lights { point"),
        std::string("lights { point { position { x: 2 y: -2 z: 2 } intensity { constant: 3 } } }").size());
    expect_same(path(without_point, 100, 1024), volpath(without_point, 100, 1024));
  }
}

}  // namespace
}  // namespace tessera::test
