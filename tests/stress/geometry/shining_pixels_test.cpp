// Dark rooms of many triangles under bright skies: no light comes in between two of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "absl/strings/str_cat.h"
#include "stress/geometry/closed_mesh.h"
#include "support/long_form.h"
#include "support/picture/render_image.h"
#include "wire/mesh_blob.h"

namespace tessera::test {
namespace shining_pixels {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

constexpr const char* kSky = "lights { infinite { radiance { constant: 1000 } } } ";
constexpr const char* kSun =
    "lights { distant { direction { x: 0.3 y: -1 z: 0.2 } irradiance { constant: 10000 } } } ";
constexpr const char* kLamp =
    "shapes { sphere { radius: 0.1 } area_light { radiance { constant: 10 } } world_from_object { elements: "
    "[1,0,0,0, 0,1,0,0.6, 0,0,1,0, 0,0,0,1] } } ";

/// A dome of 20,480 triangles, or one without the lower third of them, with the camera within.
absl::StatusOr<LoadedFile> load_dome(const std::string& around, bool open = false) {
  const render::ClosedMesh dome = render::displaced_sphere(5, 0);
  wire::MeshData mesh;
  for (const auto& p : dome.vertices) {
    for (const double x : p) mesh.positions.push_back(static_cast<float>(x));
  }
  for (const auto& triangle : dome.triangles) {
    if (open && dome.vertices[triangle[0]][1] < -0.33) continue;
    mesh.indices.insert(mesh.indices.end(), triangle.begin(), triangle.end());
  }
  SceneJob job;
  job.settings.set_spp(16);
  job.settings.set_max_depth(5);
  job.settings.set_path_sharing(v1::PATH_SHARING_OFF);
  job.settings.set_sampler(v1::SAMPLER_INDEPENDENT);
  return load_scene_text(
      absl::StrCat("camera { perspective { fov_degrees: 90 } world_from_camera { elements: [1,0,0,0.1, "
                   "0,1,0,0.2, 0,0,1,-0.3, 0,0,0,1] } } film { width: 256 height: 256 filter { kind: BOX } } "
                   "materials { name: 'grey' diffuse { reflectance { constant { constant: 0.5 } } } } "
                   "shapes { name: 'dome' material: 'grey' mesh { blob { digest: 'dome' } } } ",
                   around),
      job, render::supported_isas().front(), {{"dome", wire::encode_mesh(mesh)}});
}

TEST(ClosedMesh, LetsNoLightOfASkyIn) {
  const auto file = load_dome(kSky);
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_THAT(file->scene->warnings(), Contains(HasSubstr("robust")));
  // Fast tests let some pixels of the 65,536 shine with each seed.
  const std::uint64_t seeds = long_form() ? 20 : 3;
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    const client::Image image = render_image(*file, seed << 20);
    const client::Channel* const green = image.find("G");
    ASSERT_NE(green, nullptr);
    EXPECT_EQ(std::ranges::count_if(green->values, [](float x) { return x > 0; }), 0) << seed;
  }
}

TEST(ClosedMesh, IsMetByRobustTestsWhereLightIsBehindItAlone) {
  const auto robust = [](const std::string& around, bool open = false) {
    const auto file = load_dome(around, open);
    EXPECT_TRUE(file.ok()) << file.status();
    return file.ok() && !file->scene->warnings().empty();
  };
  EXPECT_TRUE(robust(absl::StrCat(kSky, kLamp)));
  EXPECT_TRUE(robust(kSun));
  EXPECT_TRUE(robust(absl::StrCat(kSun, kLamp)));
  // Nothing is behind it; what is behind is not brighter than what is here; much of it comes in.
  EXPECT_FALSE(robust(kLamp));
  EXPECT_FALSE(robust(absl::StrCat("lights { infinite { radiance { constant: 0.1 } } } ", kLamp)));
  EXPECT_FALSE(robust(kSky, true));
  EXPECT_FALSE(robust(""));
}

}  // namespace
}  // namespace shining_pixels
}  // namespace tessera::test
