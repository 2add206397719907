// Pictures whose paths carry light of wavelengths: grey scenes are as in RGB, colours that are seen once are,
// what is measured is as quadrature over wavelengths has it, and light that starts at lamps agrees with light
// that starts at the camera.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "absl/strings/str_cat.h"

#include "spectra/matter/metals.h"
#include "statistical/reference/lit_things.h"
#include "statistical/reference/spectral_pictures.h"

namespace tessera::test {
namespace {

/// Things in shades of grey under a grey sky and a grey lamp.
std::string grey_scene(const std::string& material) {
  return absl::StrCat(R"( materials { name: 'm' )", material, R"( }
    materials { name: 'floor' diffuse { reflectance { constant { constant: 0.5 } } } }
    shapes { disk { radius: 3 } material: 'floor' }
    shapes { sphere { radius: 0.6 } material: 'm'
      world_from_object { elements: [1,0,0,-0.6, 0,1,0,0, 0,0,1,0.7, 0,0,0,1] } } )",
                      kSky, kLamp, camera(kPerspective));
}

class GreyScenes : public testing::TestWithParam<const char*> {};

TEST_P(GreyScenes, AreAsInRgb) {
  for (const char* integrator : {"path", "volpath", "direct"}) {
    SCOPED_TRACE(integrator);
    const std::string scene = grey_scene(GetParam());
    const Pictures rgb = pictures_of(scene, integrator, 4, ""),
                   spectral = pictures_of(scene, integrator, 4, kSpectral);
    expect_same(rgb, spectral);
  }
}

INSTANTIATE_TEST_SUITE_P(Materials, GreyScenes,
                         testing::Values("diffuse { reflectance { constant { constant: 0.7 } } }",
                                         "conductor { eta { constant { constant: 0.3 } } "
                                         "k { constant { constant: 3 } } "
                                         "roughness { u { constant: 0.2 } v { constant: 0.2 } } }",
                                         "dielectric { eta { constant: 1.5 } }",
                                         "plastic { reflectance { constant { constant: 0.4 } } }"));

class Integrators : public testing::TestWithParam<const char*> {};

TEST_P(Integrators, SeeGreyScenesAsInRgb) {
  const std::string scene = grey_scene("plastic { reflectance { constant { constant: 0.4 } } }");
  const Pictures rgb = pictures_of(scene, GetParam(), 4, ""),
                 spectral = pictures_of(scene, GetParam(), 4, kSpectral);
  expect_same(rgb, spectral);
}

INSTANTIATE_TEST_SUITE_P(All, Integrators,
                         testing::Values("bdpt", "mlt", "vcm", "photon", "guided", "whitted", "raycast",
                                         "ao"));

struct Colours {
  const char* integrator;
  double relative = 1e-3;  // by how much it may be off: light that is merged is blurred
  double seen = 0.03;  // what the comparison would see; wavelengths of a pass are noise that all pixels share
};
class ColouredLight : public testing::TestWithParam<Colours> {};

TEST_P(ColouredLight, IsThatOfPaths) {
  const std::string scene =
      absl::StrCat(things("diffuse { reflectance { constant { rgb { r: 0.8 g: 0.15 b: 0.05 } } } }"),
                   lamp("disk { radius: 1 }", "two_sided: true", kAbove), camera(kPerspective));
  const Pictures path = pictures_of(scene, "path", 4, kSpectral),
                 other = pictures_of(scene, GetParam().integrator, 4, kSpectral);
  expect_same(path, other, GetParam().relative);
  for (std::size_t c = 0; c < 3; ++c) {
    Pictures brighter = other;
    for (Picture& picture : brighter)
      for (std::size_t v = c; v < picture.values.size(); v += 3)
        picture.values[v].mean *= 1 + GetParam().seen;
    EXPECT_LT(p_value_of(differences_of(path, brighter, GetParam().relative)), 1e-4) << "channel " << c;
  }
}

INSTANTIATE_TEST_SUITE_P(All, ColouredLight,
                         testing::Values(Colours{"bdpt"}, Colours{"mlt"}, Colours{"guided"},
                                         Colours{"vcm", 0.01, 0.15}));

TEST(Spectral, ColoursAreThoseOfRgbWhereTheyAreSeenOnce) {
  const std::string scene = absl::StrCat(R"( materials { name: 'm' diffuse { reflectance { constant {
      rgb { r: 0.7 g: 0.3 b: 0.1 } } } } } shapes { disk { radius: 30 } material: 'm' } )",
                                         kSky, camera(kPerspective));
  expect_color(pictures_of(scene, "path", 1, kSpectral), {0.7, 0.3, 0.1}, 0.01);
}

TEST(Spectral, LightBetweenWallsIsThatOfEachWavelength) {
  // Within a sphere that emits everywhere, light that was reflected n times is emission x reflectance^n.
  const spectra::Curve wall{{360, 480, 520, 600, 640, 830}, {0.9f, 0.8f, 0.3f, 0.35f, 0.85f, 0.9f}};
  const std::string scene =
      absl::StrCat("materials { name: 'm' diffuse { reflectance { constant { ", message_of(wall),
                   " } } } } shapes { sphere { radius: 5 } material: 'm' area_light { two_sided: true "
                   "radiance { constant: 1 } } } camera { perspective { fov_degrees: 60 } }");
  for (const std::uint32_t depth : {1u, 4u}) {
    SCOPED_TRACE(depth);
    const spectra::Triple expected = in_daylight([&](double nm) {
      double sum = 0;
      for (std::uint32_t n = 0; n <= depth; ++n) sum += std::pow(wall.at(nm), n);
      return sum;
    });
    expect_color(pictures_of(scene, "path", depth, kSpectral), expected, 5e-4);
    // Photons within this radius are on the inside of the sphere that the eye sees.
    expect_color(
        pictures_of(scene, "photon", depth,
                    absl::StrCat(kSpectral, "photon { radius: 2 photons: 512 light: PHOTON_LIGHT_ALL }")),
        expected, 5e-3);
  }
}

TEST(Spectral, MetalsReflectAsTheirIndicesHaveIt) {
  const auto gold = spectra::find_metal("Au");
  ASSERT_TRUE(gold.has_value());
  // Seen along its normal, under an even sky.
  const std::string scene = absl::StrCat(
      "materials { name: 'm' conductor { eta { constant { ", message_of(gold->eta), " } } k { constant { ",
      message_of(gold->k), " } } } } shapes { disk { radius: 50 } material: 'm' } ", kSky,
      " camera { orthographic { } world_from_camera { elements: [1,0,0,0, 0,-1,0,0, 0,0,-1,4, 0,0,0,1] } } ");
  expect_color(pictures_of(scene, "path", 1, kSpectral), in_daylight([&](double nm) {
                 const double eta = gold->eta.at(nm), k = gold->k.at(nm);
                 return ((eta - 1) * (eta - 1) + k * k) / ((eta + 1) * (eta + 1) + k * k);
               }),
               2e-3);
}

TEST(Spectral, LampsHaveTheirOwnCurves) {
  // Equal energy is not white in Rec.709.
  const spectra::Curve even{{300, 900}, {1, 1}};
  const std::string scene =
      absl::StrCat("shapes { sphere { radius: 5 } area_light { two_sided: true radiance { ", message_of(even),
                   " } } } camera { perspective { fov_degrees: 60 } }");
  expect_color(pictures_of(scene, "path", 0, kSpectral), {1.2048, 0.9483, 0.9088}, 3e-3);
}

TEST(Spectral, LightFromLampsAgreesWithPathsFromTheCamera) {
  const std::string scene =
      absl::StrCat(things("diffuse { reflectance { constant { rgb { r: 0.7 g: 0.2 b: 0.1 } } } }"),
                   lamp("disk { radius: 1 }", "two_sided: true", kAbove), camera(kPerspective));
  const Pictures path = pictures_of(scene, "path", 3, kSpectral);
  const Pictures light = pictures_of(scene, "light", 3, kSpectral);
  expect_same(path, light);
}

TEST(Spectral, FogOfOneGreyIsAsInRgb) {
  const std::string scene = absl::StrCat(
      "media { name: 'fog' extinction { constant { constant: 0.3 } } albedo { constant { constant: 0.7 } } "
      "} ",
      grey_scene("diffuse { reflectance { constant { constant: 0.7 } } }"));
  const std::string in_fog = scene.substr(0, scene.rfind('}')) + " medium: 'fog' } ";
  const Pictures rgb = pictures_of(in_fog, "volpath", 4, ""),
                 spectral = pictures_of(in_fog, "volpath", 4, kSpectral);
  expect_same(rgb, spectral);
}

TEST(Spectral, NeighboursThatShareLightAgreeWithThoseThatDoNot) {
  const std::string scene = things(kDiffuse) + kLamp + camera(kPerspective);
  const Pictures alone = pictures_of(scene, "path", 4, absl::StrCat(kSpectral, kAlone)),
                 shared = pictures_of(scene, "path", 4, absl::StrCat(kSpectral, kShared));
  expect_same(alone, shared);
}

}  // namespace
}  // namespace tessera::test
