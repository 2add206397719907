// One picture, whatever rays search.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>

#include "support/picture/render_image.h"
#include "support/picture/scene_file.h"
#include "wire/enum_words.h"
#include "wire/job_check.h"

namespace tessera::test::accelerators {
namespace {

/// Spheres, disks and a cylinder, objects placed, turned and mirrored, one that moves, glass, a lamp.
constexpr const char* kScene = R"(
film { width: 48 height: 48 filter { kind: BOX } }
camera { perspective { fov_degrees: 45 } world_from_camera {
  elements: [1,0,0,0, 0,0.96,-0.28,2.5, 0,0.28,0.96,-6, 0,0,0,1] } }
materials { name: 'white' diffuse { reflectance { constant { constant: 0.7 } } } }
materials { name: 'glass' dielectric { eta { constant: 1.5 } } }
lights { infinite { radiance { constant: 0.3 } } }
shapes { name: 'floor' material: 'white' disk { radius: 20 }
  world_from_object { elements: [1,0,0,0, 0,0,1,0, 0,-1,0,0, 0,0,0,1] } }
shapes { name: 'ball' material: 'glass' sphere { radius: 0.8 }
  world_from_object { elements: [1,0,0,-1, 0,1,0,0.8, 0,0,1,0, 0,0,0,1] } }
shapes { name: 'mover' material: 'white' sphere { radius: 0.3 }
  world_from_object { elements: [1,0,0,0, 0,1,0,0.4, 0,0,1,-1.5, 0,0,0,1] }
  world_from_object_end { elements: [1,0,0,0.5, 0,1,0,0.6, 0,0,1,-1.5, 0,0,0,1] } }
objects { name: 'post' shapes { material: 'white' cylinder { radius: 0.2 z_min: 0 z_max: 1 } }
  shapes { material: 'white' sphere { radius: 0.3 }
    world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,1,1.2, 0,0,0,1] } } }
instances { object: 'post' world_from_instance { elements: [1,0,0,1, 0,0,1,0, 0,-1,0,0.5, 0,0,0,1] } }
instances { object: 'post' world_from_instance {
  elements: [-0.7,0.2,0,1.8, 0,0,1.1,0, 0.2,0.7,0,-0.5, 0,0,0,1] } }
)";

/// Solids and surfaces that are searched for by iteration, one of each with holes, on a half-space.
constexpr const char* kSolids = R"(
film { width: 48 height: 48 filter { kind: BOX } }
camera { perspective { fov_degrees: 45 } world_from_camera {
  elements: [1,0,0,0, 0,0.96,-0.28,2.5, 0,0.28,0.96,-6, 0,0,0,1] } }
materials { name: 'white' diffuse { reflectance { constant { constant: 0.7 } } } }
materials { name: 'glass' dielectric { eta { constant: 1.5 } } }
lights { infinite { radiance { constant: 0.3 } } }
shapes { material: 'white' half_space { }
  world_from_object { elements: [1,0,0,0, 0,0,1,0, 0,1,0,0, 0,0,0,1] } }
shapes { material: 'white' torus { major_radius: 0.7 minor_radius: 0.3 } alpha { constant: 0.5 }
  world_from_object { elements: [1,0,0,-1.3, 0,1,0,1, 0,0,1,0, 0,0,0,1] } }
shapes { material: 'glass' box { low: [-0.3, 0, -0.3] high: [0.3, 0.9, 0.3] }
  world_from_object { elements: [0.8,0,0.6,0.3, 0,1,0,0.01, -0.6,0,0.8,-1, 0,0,0,1] } }
objects { name: 'heart' shapes { material: 'white' alpha { constant: 0.6 }
  implicit { expression: '(x^2 + 9/4*y^2 + z^2 - 1)^3 - x^2*z^3 - 9/80*y^2*z^3' ball { radius: 1.6 } } } }
instances { object: 'heart' world_from_instance { elements: [0.7,0,0,1.4, 0,0,0.7,1, 0,0.7,0,0, 0,0,0,1] } }
shapes { material: 'white' implicit { expression: 'sin(6*x)*cos(6*y) + sin(6*y)*cos(6*z) + sin(6*z)*cos(6*x)'
  ball { radius: 0.6 } } world_from_object { elements: [1,0,0,0, 0,1,0,2, 0,0,1,0.5, 0,0,0,1] } }
objects { name: 'die' shapes { material: 'white' csg { operation: DIFFERENCE
  parts { begin { operation: INTERSECTION } } parts { solid { box { low: [-1,-1,-1] high: [1,1,1] } } }
  parts { solid { sphere { radius: 1.4 } } } parts { end: true }
  parts { solid { torus { major_radius: 0.9 minor_radius: 0.4 } } } } } }
instances { object: 'die' world_from_instance {
  elements: [0.3,0,0.1,-0.3, 0,0.3,0,0.31, -0.1,0,0.3,-1.8, 0,0,0,1] } }
shapes { material: 'white' csg { operation: UNION parts { solid { sphere { radius: 0.3 } } }
  parts { solid { cylinder { radius: 0.1 z_min: 0 z_max: 0.6 capped: true } material: 'glass' } } }
    alpha { constant: 0.7 }
  world_from_object { elements: [1,0,0,1.2, 0,0,1,0.4, 0,-1,0,-1.2, 0,0,0,1] }
  world_from_object_end { elements: [1,0,0,1.3, 0,0,1,0.5, 0,-1,0,-1.2, 0,0,0,1] } }
)";

/// Objects three deep, mirrored, squashed and moving, of glass too, as levels that rays go down.
constexpr const char* kNested = R"(
settings { nesting: NESTING_KEPT }
film { width: 48 height: 48 filter { kind: BOX } }
camera { perspective { fov_degrees: 45 }
  world_from_camera { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-5, 0,0,0,1] } }
materials { name: 'white' diffuse { reflectance { constant { constant: 0.7 } } } }
materials { name: 'glass' dielectric { eta { constant: 1.5 } } }
lights { infinite { radiance { constant: 0.3 } } }
lights { distant { direction { x: 1 y: -2 z: 1 } irradiance { constant: 2 } } }
objects { name: 'all'
  instances { object: 'pair' world_from_instance { elements: [-0.8,0,0,-0.9, 0,0.8,0,0, 0,0,1,0, 0,0,0,1] } }
  instances { object: 'pair' world_from_instance {
    elements: [0.3,-0.5,0,0.9, 0.5,0.5,0,0, 0,0,-1,0, 0,0,0,1] }
    world_from_instance_end { elements: [0.3,-0.5,0,1.1, 0.5,0.5,0,0.1, 0,0,-1,0, 0,0,0,1] } } }
objects { name: 'pair' shapes { material: 'glass' sphere { radius: 0.6 } }
  instances { object: 'post' world_from_instance { elements: [1,0,0,0.5, 0,0,1,0.6, 0,-1,0,0.3, 0,0,0,1] } }
  instances { object: 'post' world_from_instance {
    elements: [-1,0,0,-0.4, 0,0,0.5,-1, 0,-1,0,0.5, 0,0,0,1] } } }
objects { name: 'post' shapes { material: 'white' cylinder { radius: 0.2 z_min: 0 z_max: 1 } }
  shapes { material: 'white' sphere { radius: 0.3 }
    world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,1,1.2, 0,0,0,1] } } }
instances { object: 'all' world_from_instance { elements: [1,0,0,0, 0,1,0,0.7, 0,0,1,0, 0,0,0,1] } }
instances { object: 'all' world_from_instance { elements: [0.6,0,0,0.3, 0,-0.6,0,-1, 0,0.2,0.6,1, 0,0,0,1] } }
)";

std::string pixels(const char* scene, v1::Accelerator accelerator) {
  SceneJob job;
  job.settings.set_spp(8);
  job.settings.set_accelerator(accelerator);
  const auto file = load_scene_text(scene, job, render::supported_isas().front());
  EXPECT_TRUE(file.ok()) << file.status();
  if (!file.ok()) return "";
  const client::Image image = render_image(*file);
  std::string bytes;
  for (const auto& channel : image.channels) {
    bytes.append(channel.name);
    bytes.append(reinterpret_cast<const char*>(channel.values.data()), 4 * channel.values.size());
  }
  return bytes;
}

TEST(Accelerators, AllGiveTheSameBits) {
  for (const char* scene : {kScene, kSolids, kNested}) {
    const std::string expected = pixels(scene, v1::ACCELERATOR_BRUTE);
    ASSERT_GT(expected.size(), 3u * 4 * 48 * 48);
    for (int a = v1::ACCELERATOR_BRUTE + 1; a <= v1::Accelerator_MAX; ++a) {
      const auto accelerator = static_cast<v1::Accelerator>(a);
      EXPECT_TRUE(pixels(scene, accelerator) == expected) << wire::word_of(accelerator);
    }
  }
}

/// Without any structure each ray is tested against all there is: 5 of the world's and, where it is within
/// the box of one of the posts, that one's two, so a mean between 5 and 9. Others open nodes for that.
TEST(Accelerators, TellWhatCameraRaysVisit) {
  SceneJob job;
  job.settings.set_spp(4);
  job.aovs = {v1::AOV_VISITS};
  for (const v1::Accelerator accelerator : {v1::ACCELERATOR_BRUTE, v1::ACCELERATOR_KD_SAH}) {
    SCOPED_TRACE(wire::word_of(accelerator));
    job.settings.set_accelerator(accelerator);
    for (const char* integrator : {"path", "bdpt"}) {
      job.settings.set_integrator(integrator);
      const auto file = load_scene_text(kScene, job, render::supported_isas().front());
      ASSERT_TRUE(file.ok()) << file.status();
      const client::Image image = render_image(*file);
      ASSERT_NE(image.find("visits.nodes"), nullptr);
      const std::vector<float>& nodes = image.find("visits.nodes")->values;
      const std::vector<float>& primitives = image.find("visits.primitives")->values;
      const auto [fewest, most] = std::ranges::minmax(primitives);
      if (accelerator == v1::ACCELERATOR_BRUTE) {
        EXPECT_EQ(*std::ranges::max_element(nodes), 0);
        EXPECT_EQ(fewest, 5);
        EXPECT_GT(most, 5);
        EXPECT_LE(most, 9);
      } else {
        EXPECT_GE(*std::ranges::min_element(nodes), 1);
        EXPECT_GT(most, 0);
        EXPECT_LT(std::accumulate(primitives.begin(), primitives.end(), 0.0),
                  5.0 * static_cast<double>(primitives.size()));
      }
    }
  }
  v1::JobSpec of_embree;
  of_embree.mutable_content()->mutable_algorithms()->set_integrator("path");
  EXPECT_TRUE(wire::check_settings(of_embree).ok());
  of_embree.mutable_view()->add_aovs(v1::AOV_VISITS);
  EXPECT_EQ(wire::check_settings(of_embree).message(),
            "aov 'visits': accelerator 'embree' does not tell what rays visit; all others do");
}

/// More cells a primitive: fewer tests.
TEST(Accelerators, TakeADensityForTheGrid) {
  double tests[2];
  for (int dense = 0; dense < 2; ++dense) {
    SceneJob job;
    job.settings.set_spp(4);
    job.settings.set_accelerator(v1::ACCELERATOR_GRID);
    job.settings.set_grid_density(dense ? 1000 : 0.001);
    job.aovs = {v1::AOV_VISITS};
    const auto file = load_scene_text(kScene, job, render::supported_isas().front());
    ASSERT_TRUE(file.ok()) << file.status();
    const std::vector<float> counts = render_image(*file).find("visits.primitives")->values;
    tests[dense] = std::accumulate(counts.begin(), counts.end(), 0.0);
  }
  EXPECT_LT(tests[1], tests[0]);
  v1::JobSpec refused;
  v1::Algorithms& algorithms = *refused.mutable_content()->mutable_algorithms();
  algorithms.set_integrator("path");
  algorithms.set_accelerator(v1::ACCELERATOR_GRID);
  for (const double density : {-1.0, 1e-4, 1e9, std::numeric_limits<double>::quiet_NaN()}) {
    algorithms.set_grid_density(density);
    EXPECT_EQ(std::string(wire::check_settings(refused).message()).find("grid-density is "), 0u) << density;
  }
}

}  // namespace
}  // namespace tessera::test::accelerators
