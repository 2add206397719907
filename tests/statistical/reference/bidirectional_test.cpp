// Bidirectional path tracing, and Metropolis by its ways, against path tracing where light tracing alone sees
// too little: mirrors and glass, other cameras, motion, media.
#include <gtest/gtest.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "statistical/reference/lit_things.h"
#include "statistical/reference/picture.h"

namespace tessera::test::bidirectional {
namespace {

void expect_agreement(const std::string& scene, std::uint32_t max_depth = 5, std::uint32_t seed = 0,
                      const std::string& reference = "path") {
  PictureRequest request;
  request.scene = scene;
  request.integrator = reference;
  request.blobs = light_blobs();
  request.max_depth = max_depth;
  request.spp = samples_of_form(1024);
  request.seed = seed;
  const Picture path = measure_picture(request);
  struct Other {
    const char* integrator;
    std::uint32_t spp;
    const char* settings = "";
  };
  // Close to lamps in media, paths are few and bright: chains need more candidates.
  const std::uint32_t passes = reference == "path" ? 128 : 256;
  for (const Other& other : {Other{"bdpt", 256}, Other{"mlt", passes, "mlt { mutations: 32 }"}}) {
    SCOPED_TRACE(other.integrator);
    request.integrator = other.integrator;
    request.spp = samples_of_form(other.spp);
    request.settings = other.settings;
    const Picture both = measure_picture(request);
    ASSERT_FALSE(path.values.empty() || both.values.empty());
    // A scene that is dark, or too noisy to tell anything, would prove nothing.
    EXPECT_GT(path.whole(1).mean, 0.005);
    EXPECT_LT(both.whole(1).error, noise_of_form(0.02) * both.whole(1).mean);
    expect_same(path, both);
  }
}

struct Case {
  const char* name;
  std::string scene;
};
class Bidirectional : public testing::TestWithParam<Case> {};
TEST_P(Bidirectional, AgreesWithPathTracing) { expect_agreement(GetParam().scene); }
std::string name_of_case(const testing::TestParamInfo<Case>& test) { return test.param.name; }

/// A lamp and light from all around. What lights at a point send through glass, paths from the eye never
/// find.
std::string lamps() {
  return lamp("sphere { radius: 0.7 }", "", kAbove) +
         "lights { infinite { radiance { rgb { r: 0.2 g: 0.3 b: 0.5 } } } }";
}

Case surface_case(const char* name, const std::string& material) {
  return {name, things(material) + lamps() + camera(kPerspective)};
}

INSTANTIATE_TEST_SUITE_P(
    Surfaces, Bidirectional,
    testing::Values(
        surface_case("Mirror", "conductor { reflectance { constant { constant: 0.9 } } }"),
        surface_case("Glass", "dielectric { eta { constant: 1.5 } }"),
        surface_case("ThinGlass", "thin_dielectric { eta { constant: 1.5 } }"),
        surface_case("SmoothPlastic", "plastic { }"),
        surface_case("SmoothCoat",
                     "coated_diffuse { reflectance { constant { constant: 0.6 } } eta { constant: 1.5 } }"),
        surface_case("CoatedConductor", R"(coated_conductor {
          conductor { reflectance { constant { constant: 0.8 } }
            roughness { u { constant: 0.3 } v { constant: 0.3 } } }
          eta { constant: 1.5 } roughness { u { constant: 0.2 } v { constant: 0.2 } } })"),
        surface_case("BentSoftly",
                     absl::StrCat(kDiffuse, " displacement { texture: 'lower bumps' } bends_softly: true")),
        surface_case("Mix",
                     "mix { a: 'floor' b: 'silver' amount { constant: 0.4 } } } materials { name: 'silver' "
                     "conductor { reflectance { constant { constant: 0.9 } } }"),
        surface_case(
            "RoughGlass",
            "dielectric { eta { constant: 1.5 } roughness { u { constant: 0.15 } v { constant: 0.15 } } }")),
    name_of_case);

INSTANTIATE_TEST_SUITE_P(Cameras, Bidirectional,
                         testing::Values(Case{"AllAround",
                                              things(kDiffuse) + lamps() + camera("spherical { }")},
                                         Case{"Moving", things(kDiffuse) + lamps() + camera(kPerspective, R"(
                 world_from_camera_end { elements: [1,0,0,0.4, 0,0.5448,0.8386,-4, 0,0.8386,-0.5448,3,
                   0,0,0,1] })") +
                                                            R"( shapes { sphere { radius: 0.3 } material: 'm'
                     world_from_object { elements: [1,0,0,-1, 0,1,0,-1, 0,0,1,0.4, 0,0,0,1] }
                     world_from_object_end { elements: [1,0,0,1, 0,1,0,-1, 0,0,1,0.9, 0,0,0,1] } })"}),
                         name_of_case);

TEST(BidirectionalSeeds, AllAgreeWithPathTracing) {
  const std::string scene = things(kDiffuse) + lamps() + camera(kPerspective);
  for (const std::uint32_t seed : {1u, 2u, 3u}) expect_agreement(scene, 4, seed);
}

TEST(BidirectionalDepths, AllAgreeWithPathTracing) {
  const std::string scene =
      things("conductor { reflectance { constant { constant: 0.9 } } }") + lamps() + camera(kPerspective);
  for (const std::uint32_t depth : {1u, 2u, 3u, 12u}) {
    SCOPED_TRACE(depth);
    expect_agreement(scene, depth);
  }
}

/// The things in a ball of mist that reaches beyond the camera, and a ball of smoke.
std::string mist(const std::string& extinction) {
  return things(
             "dielectric { eta { constant: 1.3 } roughness { u { constant: 0.4 } v { constant: 0.4 } } }") +
         absl::StrCat("media { name: 'mist' extinction { constant { constant: ", extinction,
                      " } } albedo { constant { rgb { r: 0.9 g: 0.8 b: 0.7 } } } g: 0.4 }") +
         R"( media { name: 'smoke' extinction { constant { rgb { r: 2 g: 3 b: 5 } } }
           albedo { constant { constant: 0.9 } } g: -0.3 }
      materials { name: 'border' interface { } }
      shapes { sphere { radius: 9 } material: 'border' interior_medium: 'mist' }
      shapes { sphere { radius: 0.5 } material: 'border' interior_medium: 'smoke' exterior_medium: 'mist'
               world_from_object { elements: [1,0,0,0.3, 0,1,0,-1, 0,0,1,0.6, 0,0,0,1] } } )" +
         camera(kPerspective, " medium: 'mist'");
}

class Media : public testing::TestWithParam<Case> {};
TEST_P(Media, AgreeWithPathTracing) { expect_agreement(GetParam().scene, 5, 0, "volpath"); }

INSTANTIATE_TEST_SUITE_P(
    Bidirectional, Media,
    testing::Values(
        Case{"Lamp", mist("0.15") + lamp("sphere { radius: 0.7 }", "", kAbove)},
        Case{"LampOnABorder",
             mist("0.15") +
                 R"( shapes { sphere { radius: 0.5 } interior_medium: 'smoke' exterior_medium: 'mist'
               area_light { radiance { constant: 5 } }
                 world_from_object { elements: [1,0,0,0.4, 0,1,0,-0.3, 0,0,1,2.2, 0,0,0,1] } } )"},
        Case{"Point", mist("0.15") +
                          "lights { point { position { x: 0.5 y: -1 z: 2.5 } intensity { constant: 8 } } }"},
        // The mist scatters within it, too.
        Case{"SoftPoint", mist("0.15") + "lights { point { position { x: 0.5 y: -1 z: 2.5 } intensity { "
                                         "constant: 8 } radius: 0.6 } }"},
        Case{"Distant",
             mist("0.15") +
                 "lights { distant { direction { x: 0.5 y: 0.3 z: -1 } irradiance { constant: 4 } } }"},
        Case{"Sky", mist("0.05") + "lights { infinite { radiance { rgb { r: 0.5 g: 1 b: 1.5 } } } }"}),
    name_of_case);

/// Nothing comes from infinity through fog without an end.
TEST(BidirectionalFog, AgreesWithPathTracing) {
  expect_agreement(things(kDiffuse) + camera(kPerspective, " medium: 'fog'") + lamps() +
                       "media { name: 'fog' extinction { constant { constant: 0.1 } } albedo { constant { "
                       "constant: 0.8 } } }",
                   5, 0, "volpath");
}

/// Surfaces that are partly open, and thin sheets, are passed on the way.
TEST(BidirectionalVeil, AgreesWithPathTracing) {
  expect_agreement(things("thin_dielectric { eta { constant: 1.5 } }") + camera(kPerspective) +
                       lamp("sphere { radius: 0.7 }", "", kAbove) + R"(
      materials { name: 'veil' diffuse { reflectance { constant { constant: 0.5 } } }
        opacity { texture: 'checks' } }
      shapes { disk { radius: 0.9 } material: 'veil'
        world_from_object { elements: [1,0,0,-0.5, 0,1,0,-0.8, 0,0,1,1.2, 0,0,0,1] } } )",
                   5, 0, "volpath");
}

}  // namespace
}  // namespace tessera::test::bidirectional
