// Skies and suns as algorithms see them: a floor under them has the illuminance that they say.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "absl/strings/str_cat.h"
#include "statistical/reference/picture.h"

namespace tessera::test {
namespace {

using std::numbers::pi;

constexpr double kReflectance = 0.5;

/// A floor seen from above, z up; a picture of its middle.
constexpr const char* kOpenFloor = R"(
  materials { name: "grey" diffuse { reflectance { constant { constant: 0.5 } } } }
  shapes { disk { radius: 2 } material: "grey" }
  camera { perspective { fov_degrees: 20 } world_from_camera { elements: [1,0,0,0, 0,-1,0,0, 0,0,-1,5, 0,0,0,1] } } )";

/// A sun at 3/5, 4/5: 53 degrees up.
std::string sky(const std::string& fields) {
  return absl::StrCat(" lights { sky { toward_sun { y: 3 z: 4 } ", fields, " } } ");
}

/// Radiance of the floor under an illuminance in lx.
double radiance(double illuminance) { return kReflectance * illuminance / pi / 683; }

PictureRequest floor_under(const std::string& light, const std::string& integrator = "path") {
  PictureRequest request;
  request.scene = kOpenFloor + light;
  request.integrator = integrator;
  return request;
}

void expect_illuminance(const std::string& light, double illuminance, const std::string& settings = "") {
  PictureRequest request = floor_under(light);
  request.settings = settings;
  expect_value(measure_picture(request), radiance(illuminance));
}

/// Within 1e-3: cells of the map that the horizon cuts have half of the ground in them.
TEST(Daylight, SkiesGiveTheIlluminanceThatTheySay) {
  for (const int type : {1, 5, 12, 16})
    expect_illuminance(sky(absl::StrCat("cie_type: ", type,
                                        " diffuse_horizontal_illuminance: 20000 sun_normal_illuminance: 0")),
                       20'000);
}

TEST(Daylight, SkiesAreFoundByPathsThatSampleNoLight) {
  expect_illuminance(sky("cie_type: 4 diffuse_horizontal_illuminance: 20000"), 20'000,
                     "direct_light: DIRECT_LIGHT_BSDF");
}

/// 0.8 is the sine of the altitude.
TEST(Daylight, SunsGiveTheIlluminanceThatTheySay) {
  const std::string both =
      "cie_type: 12 diffuse_horizontal_illuminance: 10000 sun_normal_illuminance: 80000 ";
  for (const char* const across : {"", "sun_degrees: 0", "sun_degrees: 20", "sun_degrees: 0.01"})
    expect_illuminance(sky(both + across), 10'000 + 0.8 * 80'000);
}

TEST(Daylight, AlgorithmsThatStartAtLightsSeeTheSame) {
  const std::string both =
      sky("cie_type: 12 diffuse_horizontal_illuminance: 10000 sun_normal_illuminance: 80000");
  for (const char* const integrator : {"bdpt", "light"}) {
    const Picture path = measure_picture(floor_under(both));
    expect_same(path, measure_picture(floor_under(both, integrator)));
  }
}

/// A picture that holds all of the sun, a degree across: the mean radiance times the picture's solid angle is
/// the irradiance. The solid angle is that of a square of 2 tan 0.5 degrees, but for 1e-4.
TEST(Daylight, SunsAreSeenAsBrightAsTheyShine) {
  const std::string camera = R"(
    camera { perspective { fov_degrees: 1 } world_from_camera { elements: [1,0,0,0, 0,0.8,0.6,0, 0,-0.6,0.8,0, 0,0,0,1] } } )";
  PictureRequest request;
  request.scene = camera + sky("cie_type: 5 diffuse_horizontal_illuminance: 0 sun_normal_illuminance: 68300");
  const Picture picture = measure_picture(request);
  const double side = 2 * std::tan(0.5 * pi / 180), expected = 100 / (side * side);
  for (int channel = 0; channel < 3; ++channel)
    EXPECT_NEAR(picture.whole(channel).mean, expected, 6 * picture.whole(channel).error + 1e-3 * expected);
}

/// In light of wavelengths the colours of sky and sun keep the luminance: green, which is most of it, stays
/// what it is.
TEST(Daylight, ColoursKeepTheIlluminance) {
  const std::string white =
      "cie_type: 12 diffuse_horizontal_illuminance: 30000 sun_normal_illuminance: 60000 ";
  const Picture plain = measure_picture(floor_under(sky(white)));
  const Picture coloured = measure_picture(floor_under(
      sky(white + "sky_color { blackbody { kelvin: 9000 } } sun_color { blackbody { kelvin: 5000 } }")));
  const auto luminance = [](const Picture& picture) {
    return 0.2126 * picture.whole(0).mean + 0.7152 * picture.whole(1).mean + 0.0722 * picture.whole(2).mean;
  };
  const double error = 6 * std::hypot(plain.whole(1).error, coloured.whole(1).error);
  EXPECT_NEAR(luminance(coloured), luminance(plain), error + 1e-3 * luminance(plain));
}

}  // namespace
}  // namespace tessera::test
