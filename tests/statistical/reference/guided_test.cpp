// Guided paths make path tracing's picture, and guides have the same bits however their phases are made.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "absl/strings/str_cat.h"
#include "statistical/reference/picture.h"
#include "support/picture/phases.h"

namespace tessera::test::guided {  // apart from tests that are compiled with these
namespace {

/// A closed room with a floor, walls and a sphere, lit through a window in its left wall.
constexpr const char* kRoom =
    "camera { perspective { fov_degrees: 60 } world_from_camera { "
    "elements: [1,0,0,0, 0,1,0,0, 0,0,1,-1.9, 0,0,0,1] } }"
    "materials { name: 'grey' diffuse { reflectance { constant { constant: 0.7 } } } }"
    "materials { name: 'metal' conductor { reflectance { constant { constant: 0.8 } } "
    "  roughness { u { constant: 0.3 } v { constant: 0.3 } } } }"
    "shapes { box { low: [-2.2, -1.2, -2.2] high: [2.2, -1, 2.2] } material: 'grey' }"
    "shapes { box { low: [-2.2, 1, -2.2] high: [2.2, 1.2, 2.2] } material: 'grey' }"
    "shapes { box { low: [-2.2, -1, 2] high: [2.2, 1, 2.2] } material: 'grey' }"
    "shapes { box { low: [-2.2, -1, -2.2] high: [2.2, 1, -2] } material: 'grey' }"
    "shapes { box { low: [2, -1, -2] high: [2.2, 1, 2] } material: 'grey' }"
    "shapes { box { low: [-2.2, -1, -2] high: [-2, 1, 0.4] } material: 'grey' }"
    "shapes { box { low: [-2.2, -1, 1] high: [-2, 1, 2] } material: 'grey' }"
    "shapes { box { low: [-2.2, -1, 0.4] high: [-2, 0, 1] } material: 'grey' }"
    "shapes { sphere { radius: 0.4 } material: 'metal' "
    "  world_from_object { elements: [1,0,0,0.5, 0,1,0,-0.6, 0,0,1,0.8, 0,0,0,1] } }"
    "lights { infinite { radiance { constant: 3 } } }"
    "lights { distant { direction { x: 1 y: -0.6 z: 0.1 } irradiance { constant: 20 } } }";

// So many that most cells have a density of their own.
constexpr const char* kLearned = "guided { samples: 100 }";

PictureRequest request_of(const std::string& scene, const std::string& integrator) {
  PictureRequest request;
  request.scene = scene;
  request.integrator = integrator;
  request.spp = 256;
  return request;
}

Picture guided(PictureRequest request, const char* sharing = "OFF") {
  request.integrator = "guided";
  request.settings = absl::StrCat(kLearned, " path_sharing: PATH_SHARING_", sharing);
  return measure_picture(request);
}

std::string scene_text(const std::string& name) {
  std::ifstream file("tests/statistical/unbiased/scenes/" + name + ".textproto");
  std::string text{std::istreambuf_iterator<char>(file), {}};
  return text.substr(0, text.find("\nfilm {") + 1);
}

double variance_of(const Picture& picture) {
  double sum = 0;
  for (const Picture::Value& value : picture.values) sum += value.error * value.error;
  return sum;
}

TEST(Guided, RoomLitThroughAWindowIsThatOfPathTracing) {
  const PictureRequest path = request_of(kRoom, "path");
  const Picture plain = measure_picture(path), learned = guided(path);
  ASSERT_FALSE(plain.values.empty() || learned.values.empty());
  EXPECT_GT(plain.whole(1).mean, 0.05);
  expect_same(plain, learned);
  // Its purpose: less variance, over all blocks. It is two thirds; as an estimate of 31 degrees of freedom
  // in each of 16 blocks, its ratio has a standard error of 9 %.
  EXPECT_LT(variance_of(learned), variance_of(plain));
}

TEST(Guided, PathsOfAnyLengthAreUnbiased) {
  // Roulette begins with the fourth event.
  PictureRequest path = request_of(kRoom, "path");
  path.max_depth = 12;
  expect_same(measure_picture(path), guided(path));
}

/// Neighbours are joined by the densities of both, and share what guides have found.
TEST(Guided, PathsThatPixelsShareAreUnbiased) {
  PictureRequest path = request_of(kRoom, "path");
  path.max_depth = 12;
  const Picture plain = measure_picture(path);
  expect_same(plain, guided(path, "8"));
  const Picture shared = guided(path, "16");
  expect_same(plain, shared);
  EXPECT_LT(variance_of(shared), variance_of(plain));
}

TEST(Guided, LampsAndSolidsAreThoseOfPathTracing) {
  const PictureRequest path = request_of(scene_text("solids"), "path");
  expect_same(measure_picture(path), guided(path));
}

TEST(Guided, MediaAreThoseOfVolumetricPathTracing) {
  PictureRequest path = request_of(scene_text("media"), "volpath");
  path.max_depth = 8;
  expect_same(measure_picture(path), guided(path));
}

TEST(Guided, FieldHasOneResult) {
  constexpr std::uint32_t kSide = 32;
  SceneJob job;
  job.settings.set_integrator("guided");
  job.settings.mutable_guided()->set_samples(30);
  job.settings.set_spp(4);
  const std::string film = " film { width: 32 height: 32 }";
  const auto file = load_scene_text(kRoom + film, job, render::supported_isas().front());
  ASSERT_TRUE(file.ok()) << file.status();
  const MadePhases phases = expect_one_result(*file, kSide);
  ASSERT_EQ(phases.blobs.size(), 3u);
  for (const std::string& blob : phases.blobs) EXPECT_FALSE(blob.empty());
}

}  // namespace
}  // namespace tessera::test::guided
