// Metropolis in path space against path tracing: all strategies in turn over lights, materials and motion,
// and each by itself, with chains so long that what it gets wrong would be seen.
#include <gtest/gtest.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "statistical/reference/lit_things.h"
#include "statistical/reference/picture.h"

namespace tessera::test::path_mutations {
namespace {

/// A sphere that shines, and light from all around.
std::string lamps() {
  return lamp("sphere { radius: 0.7 }", "", kAbove) +
         "lights { infinite { radiance { rgb { r: 0.2 g: 0.3 b: 0.5 } } } }";
}

void expect_agreement(const std::string& scene, const std::string& settings, std::uint32_t passes,
                      std::uint32_t seed = 0, const std::string& reference = "path") {
  PictureRequest request;
  request.scene = scene;
  request.blobs = light_blobs();
  request.seed = seed;
  request.integrator = reference;
  request.spp = samples_of_form(1024);
  const Picture path = measure_picture(request);
  request.integrator = "mlt";
  request.spp = samples_of_form(passes);
  request.settings = absl::StrCat("metropolis { ", settings, " }");
  const Picture chains = measure_picture(request);
  ASSERT_FALSE(path.values.empty() || chains.values.empty());
  // A scene that is dark, or too noisy to tell anything, would prove nothing.
  EXPECT_GT(path.whole(1).mean, 0.005);
  EXPECT_LT(chains.whole(1).error, noise_of_form(0.02) * chains.whole(1).mean);
  expect_same(path, chains);
}

struct Case {
  const char* name;
  std::string scene;
};
std::string name_of_case(const testing::TestParamInfo<Case>& test) { return test.param.name; }

Case surface_case(const char* name, const std::string& material) {
  return {name, things(material) + lamps() + camera(kPerspective)};
}
Case light_case(const char* name, const std::string& light) {
  return {name, things(kDiffuse) + light + camera(kPerspective)};
}

class PathMutations : public testing::TestWithParam<Case> {};
TEST_P(PathMutations, AgreeWithPathTracing) {
  expect_agreement(GetParam().scene, "mutations: 32 kind: MUTATION_KIND_PATH", 128);
}

INSTANTIATE_TEST_SUITE_P(
    Surfaces, PathMutations,
    testing::Values(
        surface_case("Mirror", "conductor { reflectance { constant { constant: 0.9 } } }"),
        surface_case("Glass", "dielectric { eta { constant: 1.5 } }"),
        surface_case("ThinGlass", "thin_dielectric { eta { constant: 1.5 } }"),
        surface_case("SmoothPlastic", "plastic { }"),
        surface_case("SmoothCoat",
                     "coated_diffuse { reflectance { constant { constant: 0.6 } } eta { constant: 1.5 } }"),
        surface_case("BentSoftly",
                     absl::StrCat(kDiffuse, " displacement { texture: 'lower bumps' } bends_softly: true")),
        surface_case("BentGlass",
                     "dielectric { eta { constant: 1.5 } } displacement { texture: 'lower bumps' }"),
        surface_case("Mix",
                     "mix { a: 'floor' b: 'silver' amount { constant: 0.4 } } } materials { name: 'silver' "
                     "conductor { reflectance { constant { constant: 0.9 } } }"),
        surface_case(
            "RoughGlass",
            "dielectric { eta { constant: 1.5 } roughness { u { constant: 0.15 } v { constant: 0.15 } } }")),
    name_of_case);

INSTANTIATE_TEST_SUITE_P(
    Lights, PathMutations,
    testing::Values(
        light_case("Point",
                   "lights { point { position { x: 0.5 y: -1 z: 2.5 } intensity { constant: 8 } } }"),
        light_case("Spot", R"(lights { spot { position { x: 0.5 y: -1 z: 2.5 } target { x: 0.1 z: 0.3 }
          intensity { constant: 9 } cone_angle_degrees: 35 cone_delta_degrees: 20 } })"),
        light_case("Distant",
                   "lights { distant { direction { x: 0.5 y: 0.3 z: -1 } irradiance { constant: 3 } } }"),
        light_case("Sky", "lights { infinite { radiance { rgb { r: 0.5 g: 1 b: 1.5 } } } }"),
        light_case("Disk", lamp("disk { radius: 0.7 }", "", kAbove)),
        light_case("TwoSidedDisk", lamp("disk { radius: 0.7 }", "two_sided: true", kAbove))),
    name_of_case);

INSTANTIATE_TEST_SUITE_P(Motion, PathMutations,
                         testing::Values(Case{"Moving", things(kDiffuse) + lamps() + camera(kPerspective, R"(
                 world_from_camera_end { elements: [1,0,0,0.4, 0,0.5448,0.8386,-4, 0,0.8386,-0.5448,3, 0,0,0,1] })") +
                                                            R"( shapes { sphere { radius: 0.3 } material: 'm'
                     world_from_object { elements: [1,0,0,-1, 0,1,0,-1, 0,0,1,0.4, 0,0,0,1] }
                     world_from_object_end { elements: [1,0,0,1, 0,1,0,-1, 0,0,1,0.9, 0,0,0,1] } })"},
                                         Case{"Lens", things(kDiffuse) + lamps() +
                                                          camera("perspective { fov_degrees: 50 lens_radius: "
                                                                 "0.1 focal_distance: 4.5 }")}),
                         name_of_case);

/// Light of all kinds on mirrors, glass and what lies between.
std::string all_lights(const std::string& material) {
  return things(material) + lamps() +
         "lights { point { position { x: 0.5 y: -1 z: 2.5 } intensity { constant: 4 } } } "
         "lights { distant { direction { x: 0.5 y: 0.3 z: -1 } irradiance { constant: 1 } } }" +
         camera(kPerspective);
}

class Strategy : public testing::TestWithParam<const char*> {};
TEST_P(Strategy, AgreesWithPathTracingByItself) {
  const std::string settings =
      absl::StrCat("mutations: 128 large_steps: 0.01 kind: MUTATION_KIND_", GetParam());
  // `path` never finds the light that lights at a point send through glass.
  for (const std::uint32_t seed : {1u, 2u})
    expect_agreement(all_lights("dielectric { eta { constant: 1.5 } }"), settings, 64, seed, "bdpt");
  expect_agreement(all_lights("plastic { }"), settings, 64, 3, "bdpt");
}
INSTANTIATE_TEST_SUITE_P(PathMutations, Strategy,
                         testing::Values("BIDIRECTIONAL", "LENS", "CAUSTIC", "MULTI_CHAIN"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace tessera::test::path_mutations
