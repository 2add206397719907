// Faults of a scene that its job's algorithm cannot render are told before anything is submitted, at their
// places in the file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "command/exit_code.h"
#include "command/render_options.h"
#include "unit/client/files.h"
#include "wire/algorithm.h"

namespace tessera::client::job_faults {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr char kFilmAndCamera[] = "film { width: 4 height: 4 }\ncamera { perspective { fov_degrees: 40 } }\n";

/// Returns what load_job() prints of a scene's file; empty where it is loaded.
std::string refusal(const std::string& integrator, const std::string& scene,
                    const std::string& name = "scene.textproto", int expected = kBadScene) {
  const support::TempDir directory;
  RenderOptions options;
  options.scene = directory / name;
  options.quiet = true;
  options.job.settings.set_integrator(integrator);
  write_bytes(options.scene, scene);
  int exit_code = kDone;
  testing::internal::CaptureStderr();
  const bool loaded = load_job(options, exit_code) != nullptr;
  const std::string printed = testing::internal::GetCapturedStderr();
  EXPECT_EQ(exit_code, loaded ? kDone : expected) << printed;
  return printed;
}

TEST(JobFaults, AreToldAllAtOnceAtTheirPlaces) {
  const std::string told = refusal(
      "bdpt", absl::StrCat(kFilmAndCamera,
                           "lights { name: 'sky' infinite { radiance { constant: 1 } portal {} portal {} "
                           "portal {} portal {} } }\n",
                           "shapes { name: 'ground' half_space {} }\n", "shapes { sphere { radius: 1 } }\n",
                           "objects { name: 'tree'\n  shapes { half_space {} } }\n",
                           "objects { name: 'nowhere' shapes { half_space {} } }\n",
                           "instances { object: 'tree' }\n"));
  EXPECT_THAT(told,
              HasSubstr("scene.textproto:3:1: light (sky): integrator 'bdpt' cannot begin at a portal"));
  EXPECT_THAT(told, HasSubstr("scene.textproto:4:1: shape (ground): integrator 'bdpt' cannot start light at "
                              "infinity that falls on all of a half-space"));
  EXPECT_THAT(told, HasSubstr("scene.textproto:7:3: shape: integrator 'bdpt' cannot start light"));
  EXPECT_EQ(std::ranges::count(told, '\n'), 3) << told;
}

TEST(JobFaults, AreOfAlgorithmsThatCannotDoIt) {
  const std::string floor = absl::StrCat(kFilmAndCamera, "lights { distant { direction { z: -1 } } }\n",
                                         "shapes { half_space {} }\n");
  const std::string room = absl::StrCat(kFilmAndCamera, "lights { point {} }\nshapes { half_space {} }\n");
  for (const wire::AlgorithmTraits& traits : wire::algorithms()) {
    if (traits.diffuse_only) continue;
    EXPECT_EQ(refusal(traits.name, floor).empty(), !traits.starts_at_lights) << traits.name;
    EXPECT_THAT(refusal(traits.name, room), IsEmpty()) << traits.name;
  }
}

TEST(JobFaults, MotionCountsWhereThingsMove) {
  const auto moving = [](const char* x) {
    return absl::StrCat(
        " world_from_object { elements: [1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1] } "
        "world_from_object_end { elements: [1,0,0,",
        x, ", 0,1,0,0, 0,0,1,0, 0,0,0,1] } }\n");
  };
  const auto of_cache = [&](const std::string& shape) {
    return refusal("irradiance-cache", absl::StrCat(kFilmAndCamera, shape));
  };
  EXPECT_THAT(of_cache(absl::StrCat("shapes { sphere { radius: 1 }", moving("2"))),
              HasSubstr(":3:1: shape: integrator 'irradiance-cache' wants a scene that stands still"));
  EXPECT_THAT(of_cache(absl::StrCat("shapes { sphere { radius: 1 }", moving("1"))), IsEmpty());
  // Lamps stay where they are.
  EXPECT_THAT(of_cache(absl::StrCat("shapes { sphere { radius: 1 } area_light {}", moving("2"))), IsEmpty());
  EXPECT_THAT(of_cache("objects { name: 'o' shapes { sphere { radius: 1 } } }\n"
                       "instances { object: 'o' world_from_instance_end { elements: [1,0,0,2, 0,1,0,0, "
                       "0,0,1,0, 0,0,0,1] } }\n"),
              HasSubstr("instance 0 (o): integrator 'irradiance-cache' wants"));
}

TEST(JobFaults, RadiosityNamesAllThatIsNotDiffuse) {
  const std::string scene = absl::StrCat(
      kFilmAndCamera, "materials { name: 'metal' conductor {} }\nmaterials { name: 'paint' diffuse {} }\n",
      "materials { name: 'unused' dielectric {} }\nmaterials { name: 'both' mix { a: 'paint' b: 'metal' } "
      "}\n",
      "shapes { box { low: [0, 0, 0] high: [1, 1, 1] } material: 'both' }\n",
      "shapes { sphere { radius: 1 } material: 'paint' }\n",
      "shapes { polygon { corners: [0,0,0, 1,0,0, 1,1,0] } alpha { constant: 0.5 } }\n");
  const std::string told = refusal("radiosity", scene);
  EXPECT_THAT(told,
              AllOf(HasSubstr(":3:1: material (metal): integrator 'radiosity' is for diffuse materials"),
                    HasSubstr(":8:1: shape: integrator 'radiosity' is for meshes of triangles"),
                    HasSubstr(":9:1: shape: integrator 'radiosity' is for closed surfaces")));
  EXPECT_EQ(std::ranges::count(told, '\n'), 3) << told;
}

TEST(JobFaults, OfTheCameraAreAtTheCamera) {
  EXPECT_THAT(refusal("path", "film { width: 4 height: 4 }\ncamera { perspective { fov_degrees: 200 } }\n"),
              HasSubstr("scene.textproto:2:1: camera: a field of view of 200"));
  EXPECT_THAT(refusal("light", "film { width: 4 height: 4 }\ncamera { spherical {} }\n"),
              HasSubstr("scene.textproto:2:1: camera: integrator 'light' needs a perspective"));
}

TEST(JobFaults, OfPbrtFilesHaveTheirLines) {
  const std::string told = refusal("bdpt",
                                   "Camera \"perspective\"\nWorldBegin\nLightSource \"infinite\"\n"
                                   "Shape \"halfspace\"\n",
                                   "scene.pbrt");
  EXPECT_THAT(told, HasSubstr("scene.pbrt:4:"));
  EXPECT_THAT(told, HasSubstr("integrator 'bdpt' cannot start light at infinity"));
}

}  // namespace
}  // namespace tessera::client::job_faults
