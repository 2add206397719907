// Warnings of light that an algorithm never finds.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "support/picture/scene_file.h"

namespace tessera::test {
namespace unseen_light_test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kSpot =
    "lights { name: 'lamp' spot { position { z: 1 } target { z: 3 } intensity { rgb { r: 1 g: 1 b: 1 } } "
    "cone_angle_degrees: 60 } }";
constexpr const char* kSky = "lights { infinite { radiance { rgb { r: 1 g: 1 b: 1 } } } }";
constexpr const char* kPicture = "camera { perspective { fov_degrees: 60 } } film { width: 8 height: 8 } ";
constexpr const char* kMeter =
    "camera { probes { probes { kind: PLANE point {} axis { z: 1 } } } } "
    "film { width: 8 height: 8 filter { kind: BOX radius_x: 0.49 radius_y: 0.49 } } ";
constexpr const char* kMirror = "conductor {}";
constexpr const char* kClearCoat = "coated_diffuse {}";
constexpr const char* kFrosted = "dielectric { roughness { u { constant: 0.3 } v { constant: 0.3 } } }";

/// Returns the warnings of a room with a ball of the material, in which `light` shines.
std::vector<std::string> warnings(const std::string& integrator, const std::string& light,
                                  const std::string& ball, std::uint32_t max_depth = 5,
                                  const char* camera = kPicture) {
  SceneJob job;
  job.width = 8, job.height = 8;
  job.settings.set_integrator(integrator);
  job.settings.set_max_depth(max_depth);
  const auto file = load_scene_text(
      absl::StrCat(camera, light, " materials { name: 'paint' diffuse {} } materials { name: 'ball' ", ball,
                   " } materials { name: 'unused mirror' conductor {} }"
                   " shapes { material: 'paint' sphere { radius: 5 } }"
                   " shapes { material: 'ball' sphere { radius: 1 }"
                   "          world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,1,3, 0,0,0,1] } }"),
      job, render::supported_isas().front());
  EXPECT_TRUE(file.ok()) << file.status();
  return file.ok() ? file->scene->warnings() : std::vector<std::string>{};
}

TEST(UnseenLight, OfPathsFromTheCameraIsCausticsOfLightsWithoutArea) {
  for (const char* ball : {kMirror, kClearCoat, "dielectric {}", "thin_dielectric {}", "plastic {}"}) {
    EXPECT_THAT(
        warnings("path", kSpot, ball),
        Contains(AllOf(HasSubstr("'path' never finds the light of 'lamp'"), HasSubstr("material 'ball'"),
                       HasSubstr("vcm"), HasSubstr("photon"), HasSubstr("bdpt"))))
        << ball;
  }
  EXPECT_THAT(warnings("guided", kSpot, kMirror), Contains(HasSubstr("'guided' never finds")));
}

TEST(UnseenLight, OfMetersIsLightThatReachesThemByMirrors) {
  // Light that one mirror sends to the meter takes a single event.
  for (const std::uint32_t max_depth : {1u, 5u}) {
    EXPECT_THAT(warnings("bdpt", kSpot, kMirror, max_depth, kMeter),
                Contains(AllOf(HasSubstr("'bdpt' never finds the light of 'lamp'"),
                               HasSubstr("straight on a meter"))));
    EXPECT_THAT(warnings("path", kSpot, kMirror, max_depth, kMeter),
                Contains(HasSubstr("'path' never finds")));
  }
  for (const char* const integrator : {"path", "bdpt"}) {
    EXPECT_THAT(warnings(integrator, kSpot, "diffuse {}", 5, kMeter), IsEmpty());
    EXPECT_THAT(warnings(integrator, kSky, kMirror, 5, kMeter), IsEmpty());
  }
}

TEST(UnseenLight, IsNoneWhereLightsHaveAreaOrSurfacesSpreadLight) {
  EXPECT_THAT(warnings("path", kSky, kMirror), IsEmpty());
  EXPECT_THAT(warnings("path", kSpot, kFrosted), IsEmpty());
  EXPECT_THAT(warnings("path", kSpot, "diffuse {}"), IsEmpty());
  // The light of one bounce has no caustics.
  EXPECT_THAT(warnings("path", kSpot, kMirror, 1), IsEmpty());
}

TEST(UnseenLight, OfBothEndsIsCausticsInMirrors) {
  EXPECT_THAT(warnings("bdpt", kSpot, kMirror), Contains(HasSubstr("where it is seen in a mirror")));
  EXPECT_THAT(warnings("bdpt", kSky, kMirror), IsEmpty());
  EXPECT_THAT(warnings("bdpt", kSpot, kMirror, 2), IsEmpty());
}

TEST(UnseenLight, OfPathsFromLightsIsWhatMirrorsShow) {
  EXPECT_THAT(warnings("light", kSpot, kMirror), Contains(HasSubstr("does not see what is behind a mirror")));
  EXPECT_THAT(warnings("light", kSpot, kFrosted), IsEmpty());
}

TEST(UnseenLight, IsNoneWhereVerticesAreMerged) {
  EXPECT_THAT(warnings("photon", kSpot, kMirror), IsEmpty());
  EXPECT_THAT(warnings("vcm", kSpot, kMirror), IsEmpty());
}

}  // namespace
}  // namespace unseen_light_test
}  // namespace tessera::test
