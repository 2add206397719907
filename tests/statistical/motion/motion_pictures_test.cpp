// Pictures of what moves through several keys against the mean of still pictures, and by rolling shutters:
// integrators against each other.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "statistical/reference/spectral_pictures.h"

namespace tessera::test::motion_pictures {
namespace {

constexpr std::uint32_t kDepth = 2;

/// The mean of 256 still pictures, 64 for each seed: one in each of 64 equal parts of the time, at any place
/// within it.
Pictures of_stills(const std::function<std::string(double)>& scene_at) {
  constexpr int kStills = 64, kSeeds = 4;
  Pictures pictures;
  for (int seed = 0; seed < kSeeds; ++seed) {
    Picture mean;
    for (int i = 0; i < kStills; ++i) {
      const int number = 1000 + seed * kStills + i;
      PictureRequest request;
      request.scene = scene_at((i + std::fmod(0.5 + 0.6180339887498949 * number, 1.0)) / kStills);
      request.max_depth = kDepth;
      request.settings = kAlone;
      request.spp = 32;
      request.seed = static_cast<std::uint32_t>(number);
      request.blobs = light_blobs();
      const Picture still = measure_picture(request);
      mean.values.resize(still.values.size());
      for (std::size_t v = 0; v < still.values.size(); ++v) {
        mean.values[v].mean += still.values[v].mean / kStills;
        mean.values[v].error = std::hypot(mean.values[v].error, still.values[v].error / kStills);
      }
    }
    pictures.push_back(mean);
  }
  return pictures;
}

/// Fails where the pictures differ, and where a difference of the part `seen` would not have been found.
void expect_alike(const Pictures& a, const Pictures& b, double relative, double seen) {
  expect_same(a, b, relative);
  Pictures brighter = b;
  for (Picture& picture : brighter)
    for (Picture::Value& value : picture.values) value.mean *= 1 + seen;
  EXPECT_LT(p_value_of(differences_of(a, brighter, relative)), 1e-4) << "nothing can be told";
}

Pictures moving(const std::string& scene, const std::string& settings = kAlone) {
  return pictures_of(scene, "path", kDepth, settings);
}

std::string elements(const std::string& numbers) { return absl::StrCat("{ elements: [", numbers, "] }"); }

/// A placing that is turned about y, at x and z.
std::string about_y(double degrees, double x, double y, double z, double size = 1) {
  const double a = degrees * std::numbers::pi / 180, c = size * std::cos(a), s = size * std::sin(a);
  return elements(absl::StrFormat("%.15g,0,%.15g,%.15g, 0,%.15g,0,%.15g, %.15g,0,%.15g,%.15g, 0,0,0,1", c, s,
                                  x, size, y, -s, c, z));
}

constexpr const char* kRoom = R"(
  materials { name: 'm' diffuse { reflectance { constant { rgb { r: 0.8 g: 0.5 b: 0.3 } } } } }
  materials { name: 'floor' diffuse { reflectance { constant { constant: 0.6 } } } }
  lights { point { position { x: 1 y: 3 z: -1 } intensity { constant: 20 } } }
  lights { infinite { radiance { rgb { r: 0.2 g: 0.3 b: 0.4 } } } }
  shapes { disk { radius: 20 } material: 'floor' world_from_object { elements: [1,0,0,0, 0,0,1,-1, 0,-1,0,0,
    0,0,0,1] } } )";
constexpr const char* kCamera =
    " camera { perspective { fov_degrees: 50 } world_from_camera { elements: "
    "[1,0,0,0, 0,0.94,-0.34,1.4, 0,0.34,0.94,-4, 0,0,0,1] } } ";
constexpr const char* kBlade = "box { low: [-1.2, -0.2, -0.1] high: [1.2, 0.2, 0.1] } material: 'm'";

TEST(MotionPictures, AWheelOfOneTurnAndAHalfIsTheMeanOfStills) {
  // It rolls along, the turn apart.
  const auto place = [](double t) {
    return elements(absl::StrFormat("1,0,0,%.15g, 0,1,0,0, 0,0,1,0, 0,0,0,1", -1 + t));
  };
  const std::string moves =
      absl::StrCat(kRoom, kCamera, "shapes { ", kBlade, " world_from_object ", place(0),
                   " motion { time: 0.4 place ", place(0.5), " turn { axis { z: 1 } degrees: -240 } } ",
                   " motion { time: 1 place ", place(1), " turn { axis { z: 1 } degrees: -300 } } }");
  const auto still = [&](double t) {
    const double degrees = t < 0.4 ? -240 * t / 0.4 : -240 - 300 * (t - 0.4) / 0.6;
    const double x = -1 + (t < 0.4 ? 0.5 * t / 0.4 : 0.5 + 0.5 * (t - 0.4) / 0.6);
    const double a = degrees * std::numbers::pi / 180, c = std::cos(a), s = std::sin(a);
    return absl::StrCat(
        kRoom, kCamera, "shapes { ", kBlade, " world_from_object ",
        elements(absl::StrFormat("%.15g,%.15g,0,%.15g, %.15g,%.15g,0,0, 0,0,1,0, 0,0,0,1", c, -s, x, s, c)),
        " }");
  };
  expect_alike(moving(moves), of_stills(still), 2e-3, 0.03);
}

TEST(MotionPictures, ACameraOfThreeKeysSeesTheMeanOfStills) {
  // Along a bend, at times that only 100 even steps meet.
  constexpr double kFirst = 0.27, kSecond = 0.73;
  const auto pose = [](double t) {
    const double x = t < kFirst ? -1 + t / kFirst : t < kSecond ? 0 : (t - kSecond) / (1 - kSecond);
    const double degrees = t < kFirst    ? 20 - 20 * t / kFirst
                           : t < kSecond ? 30 * (t - kFirst) / (kSecond - kFirst)
                                         : 30 - 40 * (t - kSecond) / (1 - kSecond);
    return about_y(degrees, x, 0, -4);
  };
  const std::string things = absl::StrCat(kRoom, "shapes { ", kBlade, " }");
  const std::string moves = absl::StrFormat(
      "%s camera { perspective { fov_degrees: 60 } world_from_camera %s motion { time: %.12g place %s } "
      "motion { time: %.12g place %s } motion { time: 1 place %s } } ",
      things, pose(0), kFirst, pose(kFirst), kSecond, pose(kSecond), pose(1));
  const auto still = [&](double t) {
    return absl::StrCat(things, " camera { perspective { fov_degrees: 60 } world_from_camera ", pose(t),
                        " }");
  };
  expect_alike(moving(moves), of_stills(still), 2e-3, 0.03);
}

/// An arm that turns, and on it a wheel that turns, each with keys of its own.
std::string levels(const std::string& arm, const std::string& wheel, const std::string& nesting) {
  return absl::StrCat(
      kRoom, kCamera, "objects { name: 'blades' shapes { ", kBlade,
      " } shapes { sphere { radius: 0.4 } material: 'm' world_from_object { elements: [1,0,0,1, "
      "0,1,0,0.3, 0,0,1,0, 0,0,0,1] } } } objects { name: 'arm' instances { object: 'blades' ",
      wheel, " } instances { object: 'blades' ", wheel, " } } instances { object: 'arm' ", arm,
      " } settings { nesting: ", nesting, " }");
}

TEST(MotionPictures, LevelsWithKeysOfTheirOwnAreTheMeanOfStills) {
  const auto arm = [](double t) { return about_y(t < 0.25 ? 160 * t : 40 - 80 * (t - 0.25), 0, 0, 0); };
  const auto wheel = [](double t) { return about_y(0, t < 0.5 ? t : 0.5, 0.5, 0, 0.7); };
  const auto still = [&](double t) {
    return levels(absl::StrCat("world_from_instance ", arm(t)),
                  absl::StrCat("world_from_instance ", wheel(t)), "NESTING_FLATTENED");
  };
  const Pictures stills = of_stills(still);
  for (const char* const nesting : {"NESTING_KEPT", "NESTING_FLATTENED"}) {
    SCOPED_TRACE(nesting);
    const std::string moves =
        levels(absl::StrCat("world_from_instance ", arm(0), " motion { time: 0.25 place ", arm(0.25),
                            " } motion { time: 1 place ", arm(1), " }"),
               absl::StrCat("world_from_instance ", wheel(0), " motion { time: 0.5 place ", wheel(0.5), " }"),
               nesting);
    expect_alike(moving(moves), stills, 2e-3, 0.03);
  }
}

// ---------------------------------------------------------------- rolling shutters

/// A lamp, a ball that goes fast over a floor, and a camera that turns; no row sees them at the time of
/// another.
std::string rolling_scene(const std::string& shutter) {
  return absl::StrCat(
      kTextures, R"(
    materials { name: 'm' diffuse { reflectance { constant { rgb { r: 0.7 g: 0.5 b: 0.9 } } } } }
    materials { name: 'floor' diffuse { reflectance { constant { rgb { r: 0.6 g: 0.5 b: 0.4 } } } } }
    shapes { disk { radius: 3 } material: 'floor' }
    shapes { sphere { radius: 0.6 } material: 'm'
      world_from_object { elements: [1,0,0,-1.2, 0,1,0,0.3, 0,0,1,0.7, 0,0,0,1] }
      motion { time: 0.4 place { elements: [1,0,0,0.9, 0,1,0,-0.6, 0,0,1,0.7, 0,0,0,1] } }
      motion { time: 1 place { elements: [1,0,0,0, 0,1,0,1.2, 0,0,1,1.2, 0,0,0,1] } } } )",
      lamp("disk { radius: 1 }", "two_sided: true", kAbove),
      camera(kPerspective, absl::StrCat("motion { time: 1 turn { axis { z: 1 } degrees: 25 } } "
                                        "shutter { ",
                                        shutter, " }")));
}

constexpr const char* kRolling = "trapezoid { opening: 0.3 closing: 0.1 } rolling { duration: 0.25 }";
constexpr const char* kColumns = "rolling { direction: LEFT duration: 0.5 }";

struct RollingCase {
  const char* name;
  const char* shutter = kRolling;
  double relative = 1e-3, seen = 0.04;
  const char* settings = "";
};

class RollingShutter : public testing::TestWithParam<RollingCase> {};

TEST_P(RollingShutter, AgreesWithPathsOfPixelsAlone) {
  const std::string scene = rolling_scene(GetParam().shutter);
  expect_alike(pictures_of(scene, "path", 3, kAlone),
               pictures_of(scene, GetParam().name, 3, GetParam().settings), GetParam().relative,
               GetParam().seen);
}

// Merging blurs.
INSTANTIATE_TEST_SUITE_P(
    Integrators, RollingShutter,
    testing::Values(RollingCase{"path", kRolling, 1e-3, 0.04, kShared},
                    RollingCase{"path", kColumns, 1e-3, 0.04, kShared}, RollingCase{"volpath"},
                    RollingCase{"light"}, RollingCase{"light", kColumns},
                    RollingCase{"bdpt", kRolling, 1e-3, 0.06}, RollingCase{"bdpt", kColumns},
                    RollingCase{"mlt", kRolling, 1e-3, 0.08}, RollingCase{"vcm", kColumns, 0.01, 0.25}),
    [](const auto& test) {
      return absl::StrCat(test.param.name, test.param.shutter == kColumns ? "Columns" : "Rows", test.index);
    });

TEST(RollingShutter, ShowsRowsThatDifferFromOthers) {
  // The same scene with the shutter open for all rows at once is another picture.
  EXPECT_LT(p_value_of(differences_of(pictures_of(rolling_scene(kRolling), "path", 3, kAlone),
                                      pictures_of(rolling_scene(""), "path", 3, kAlone))),
            1e-4);
}

}  // namespace
}  // namespace tessera::test::motion_pictures
