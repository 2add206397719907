// Light that passes clear glass unbent: the same picture as traced light where glass does not bend it, with
// far less noise, and none of it twice.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "absl/strings/str_cat.h"
#include "statistical/reference/picture.h"

namespace tessera::test {
namespace {

// The floor's square of side 2, seen from below the glass.
constexpr const char* kFloor = R"(
  materials { name: 'matt' diffuse { reflectance { constant { constant: 0.5 } } } }
  materials { name: 'black' diffuse { reflectance { constant { constant: 0 } } } }
  materials { name: 'curtain' diffuse { reflectance { constant { constant: 0.2 } } }
    opacity { constant: 0.4 } }
  materials { name: 'sheet' thin_dielectric { eta { constant: 1.5 } } }
  materials { name: 'glass' dielectric { eta { constant: 1.5 } } }
  materials { name: 'red sheet' thin_dielectric { eta { constant: 1.5 }
              transmission_tint { constant { rgb { r: 0.9 g: 0.3 b: 0.5 } } } } }
  materials { name: 'red' dielectric { eta { constant: 1.5 }
              transmission_tint { constant { rgb { r: 0.9 g: 0.5 b: 0.7 } } } } }
  materials { name: 'air' dielectric { eta { constant: 1 } } }
  shapes { disk { radius: 9 } material: 'matt' }
  camera { orthographic { } world_from_camera { elements: [1,0,0,0, 0,-1,0,0, 0,0,-1,0.8, 0,0,0,1] } }
)";

constexpr const char* kLamp = R"(
  shapes { sphere { radius: 0.5 } material: 'black' area_light { radiance { constant: 4 } }
           world_from_object { elements: [1,0,0,0.4, 0,1,0,0, 0,0,1,2.2, 0,0,0,1] } }
)";
constexpr const char* kSun =
    "lights { distant { direction { x: 0.3 y: 0.1 z: -1 } irradiance { constant: 2 } } }";

std::string disk(const char* material, double height, bool turned) {
  const int z = turned ? -1 : 1;
  return absl::StrCat("shapes { disk { radius: 30 } material: '", material,
                      "' world_from_object { elements: [1,0,0,0, 0,", z, ",0,0, 0,0,", z, ",", height,
                      ", 0,0,0,1] } }\n");
}

/// Outside is above the upper side and below the lower one.
std::string slab(double thickness, const char* material = "glass") {
  return disk(material, 1, true) + disk(material, 1 + thickness, false);
}

Picture picture(const std::string& scene, const char* shadows, const char* integrator,
                std::uint32_t max_depth = 8) {
  PictureRequest request;
  request.scene = scene;
  request.integrator = integrator;
  request.settings = absl::StrCat("glass_shadows: GLASS_SHADOWS_", shadows);
  request.max_depth = max_depth;
  return measure_picture(request);
}

class GlassShadows : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(, GlassShadows, testing::Values("path", "volpath", "guided"));

TEST_P(GlassShadows, SheetsAreExact) {
  const std::string scene = absl::StrCat(kFloor, disk("sheet", 1, false), kLamp);
  const Picture traced = picture(scene, "TRACED", GetParam()),
                straight = picture(scene, "STRAIGHT", GetParam());
  expect_same(traced, straight);
  EXPECT_LT(straight.whole(0).error, 0.3 * traced.whole(0).error);
}

TEST_P(GlassShadows, ThinSlabsMoveLightByNextToNothing) {
  const std::string scene = absl::StrCat(kFloor, slab(0.004), kLamp);
  const Picture traced = picture(scene, "TRACED", GetParam()),
                straight = picture(scene, "STRAIGHT", GetParam());
  expect_same(traced, straight, 3e-3);
  EXPECT_LT(straight.whole(0).error, 0.5 * traced.whole(0).error);
}

TEST_P(GlassShadows, TintedGlassTints) {
  for (const std::string& glass : {disk("red sheet", 1, false), slab(0.004, "red")}) {
    const std::string scene = absl::StrCat(kFloor, glass, kLamp);
    const Picture straight = picture(scene, "STRAIGHT", GetParam());
    expect_same(picture(scene, "TRACED", GetParam()), straight, 3e-3);
    EXPECT_LT(straight.whole(1).mean, 0.7 * straight.whole(0).mean);
  }
}

/// Nothing but rays to it finds the sun; how much gets through a sheet is known.
TEST_P(GlassShadows, TheSunShinesThrough) {
  // Under this angle on both sides, with all orders of reflection between them.
  const double cosine = 1 / std::sqrt(1 + 0.3 * 0.3 + 0.1 * 0.1);
  const double inside = std::sqrt(1 - (1 - cosine * cosine) / (1.5 * 1.5));
  const auto reflectance = [](double a, double b) { return std::pow((a - b) / (a + b), 2); };
  const double once = (reflectance(1.5 * cosine, inside) + reflectance(cosine, 1.5 * inside)) / 2;
  // Light that the floor sends to the sheet does not come back within two events.
  const std::string under = absl::StrCat(kFloor, disk("sheet", 1, false), kSun);
  const Picture open = picture(absl::StrCat(kFloor, kSun), "TRACED", GetParam(), 2);
  expect_value(picture(under, "TRACED", GetParam(), 2), 0);
  expect_value(picture(under, "STRAIGHT", GetParam(), 2), open.whole(0).mean * (1 - once) / (1 + once), 1e-5);
}

/// Paths find the sky by themselves, and must not be believed twice.
TEST_P(GlassShadows, TheSkyShinesOnce) {
  const std::string scene = absl::StrCat(kFloor, slab(0.1), kSky);
  expect_same(picture(scene, "TRACED", GetParam()), picture(scene, "STRAIGHT", GetParam()));
}

/// Light that passes a curtain is counted once, by paths (`path`) or by rays to lights as well (`volpath`).
TEST_P(GlassShadows, CurtainsAreAsBefore) {
  const std::string scene = absl::StrCat(kFloor, disk("sheet", 1, false), disk("curtain", 1.2, false), kLamp);
  expect_same(picture(scene, "TRACED", GetParam()), picture(scene, "STRAIGHT", GetParam()));
}

/// A ball of index 1 bends no light, so even a curved one is exact.
TEST_P(GlassShadows, IndexMatchedBallsAreInvisible) {
  const std::string scene = absl::StrCat(kFloor, kLamp);
  const std::string ball =
      "shapes { sphere { radius: 0.45 } material: 'air' "
      "world_from_object { elements: [1,0,0,0.3, 0,1,0,0.1, 0,0,1,0.5, 0,0,0,1] } }";
  expect_same(picture(scene, "TRACED", GetParam()), picture(scene + ball, "STRAIGHT", GetParam()));
}

}  // namespace
}  // namespace tessera::test
