// Meters against closed forms: all figures within their own errors, and these small.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "agreement.h"
#include "measure_text.h"
#include "photometry/units/weighting.h"
#include "scene_text.h"

namespace tessera::test {
namespace {

constexpr double kPi = std::numbers::pi;
void expect_measured(const MeasuredCase& test) { expect_agreement({test}); }

const char* const kPoint = "lights { point { position { z: 2 } intensity { rgb { r: 3 g: 3 b: 3 } } } } ";
const char* const kSky = "lights { infinite { radiance { rgb { r: 1 g: 1 b: 1 } } } } ";

TEST(Measure, FollowsTheInverseSquareAndTheCosine) {
  const double oblique = std::cos(kPi / 3);
  expect_measured({.name = "point",
                   .scene = kPoint,
                   .meters = point_meter("below", "", "z: 1") + point_meter("twice as far", "z: -2", "z: 1") +
                             point_meter("turned by 60 degrees", "", "x: 0.8660254 z: 0.5") +
                             point_meter("turned away", "", "z: -1") +
                             point_meter("all around", "", "z: 1", "SPHERE") +
                             point_meter("cylinder", "", "x: 1", "CYLINDER") +
                             point_meter("half of a ball", "", "x: 1", "HALF_SPHERE"),
                   .truths = {3.0 / 4, 3.0 / 16, 3.0 / 4 * oblique, 0, 3.0 / 4, 3.0 / 4 / kPi, 3.0 / 4 / 4}});
}

TEST(Measure, FindsTheFluxAndIntensityOfAPoint) {
  expect_measured({.name = "flux",
                   .scene = kPoint,
                   .meters = "meters { name: 'flux' unit: 'W' flux { escaping: true } } "
                             "meters { name: 'intensity' unit: 'W/sr' intensity { gamma_step_degrees: 45 "
                             "c_step_degrees: 120 } }",
                   .truths = {12 * kPi, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3},
                   .rounding = kMargin});
}

TEST(Measure, ReadsAnEvenSky) {
  expect_measured({.name = "sky",
                   .scene = kSky,
                   .meters = point_meter("plane", "", "x: 1") + point_meter("sphere", "", "z: 1", "SPHERE") +
                             point_meter("cylinder", "", "z: 1", "CYLINDER") +
                             point_meter("half cylinder", "", "z: 1", "HALF_CYLINDER", "front { x: 1 }") +
                             point_meter("half sphere", "", "z: 1", "HALF_SPHERE") +
                             "meters { name: 'ray' unit: 'W/(m2 sr)' radiance { ray { toward { x: 1 } } } } "
                             "meters { name: 'spot' unit: 'W/(m2 sr)' radiance { ray { toward { x: 1 } "
                             "field_degrees: 10 } } }",
                   .truths = {kPi, 4 * kPi, kPi, kPi, kPi, 1, 1}});
}

std::string emitting_disk(double radius, double height) {
  return "shapes { disk { radius: " + number(radius) +
         " } material: 'black' name: 'lamp' area_light { radiance { rgb { r: 1 g: 1 b: 1 } } } "
         "world_from_object { elements: [1,0,0,0, 0,-1,0,0, 0,0,-1," +
         number(height) + ", 0,0,0,1] } } ";
}

TEST(Measure, ReadsSourcesOfSomeSize) {
  // A disk of radius r at a distance h: pi L r^2 / (r^2 + h^2); a ball of radius R: pi L (R / d)^2.
  expect_measured({.name = "disk",
                   .scene = emitting_disk(1.5, 2),
                   .meters = point_meter("below", "", "z: 1"),
                   .truths = {kPi * 2.25 / (2.25 + 4)}});
  expect_measured({.name = "ball",
                   .scene =
                       "shapes { sphere { radius: 0.5 } material: 'black' area_light { radiance { rgb { r: "
                       "1 g: 1 b: 1 } } } world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,1,2, "
                       "0,0,0,1] } }",
                   .meters = point_meter("below", "", "z: 1") + point_meter("around", "", "z: 1", "SPHERE"),
                   .truths = {kPi / 16, 2 * kPi * (1 - std::sqrt(1 - 1.0 / 16))}});
}

TEST(Measure, ReadsWhatLeavesALamp) {
  // B = pi L; power: area times that, on one side.
  const std::string lamp = emitting_disk(1.5, 2);
  expect_measured(
      {.name = "exitance",
       .scene = lamp,
       .meters = "meters { name: 'B' unit: 'W/m2' exitance { receivers { surface { shape: 'lamp' } } } } "
                 "meters { name: 'back' unit: 'W/m2' exitance { receivers { surface { shape: 'lamp' "
                 "inside: true } } } } "
                 "meters { name: 'power' unit: 'W' flux { side: EMITTED receivers { surface { shape: "
                 "'lamp' } } } } "
                 "meters { name: 'escaping' unit: 'W' flux { escaping: true } }",
       .truths = {kPi, 0, kPi * kPi * 2.25, kPi * kPi * 2.25}});
}

TEST(Measure, TellsTheFluxOfLightsByName) {
  const auto flux = [](const std::string& name) {
    return "meters { name: 'flux of " + name + "' unit: 'W' flux { side: EMITTED light: '" + name + "' } } ";
  };
  const std::string bright = " intensity { rgb { r: 3 g: 3 b: 3 } } ", place = " position { z: 2 } ";
  const std::string placed = " world_from_light { elements: [0,0,1,1, 1,0,0,0, 0,1,0,2, 0,0,0,1] } ";
  const std::string glows = " area_light { radiance { rgb { r: 1 g: 1 b: 1 } } ";
  // A falloff linear in the angle from 0.3 to 0.7: 2 pi times the integral of its product with the sine.
  const double inner = 20 * kPi / 180, outer = 40 * kPi / 180;
  const double linear = 2 * kPi * (1 - (std::sin(outer) - std::sin(inner)) / (outer - inner));
  const double tan = std::tan(kPi / 6);
  expect_measured(
      {.name = "lights",
       .scene = "lights { name: 'point' group: 'both' point {" + place + bright + "} scale: 2 } " +
                "lights { name: 'soft' point { radius: 0.1" + place + bright + "} } " +
                "lights { name: 'spot' group: 'both' spot { cone_angle_degrees: 40" + place + bright +
                "} } " + "lights { name: 'smooth' spot { cone_angle_degrees: 40 cone_delta_degrees: 20" +
                place + bright +
                "} } lights { name: 'linear' spot { falloff: LINEAR cone_angle_degrees: 40 "
                "cone_delta_degrees: 20" +
                place + bright + "} } lights { name: 'slides' projection { fov_degrees: 60" + placed +
                bright + "} } lights { name: 'map' goniometric {" + placed + bright + "} } " +
                "lights { name: 'bulb' point {" + place + bright +
                "} amount { value: 1366 unit: 'lm' } } shapes { polygon { corners: [0,0,0, 2,0,0, 0,1,3] } "
                "material: 'black' name: 'polygon'" +
                glows + "two_sided: true } } shapes { sphere { radius: 0.5 } material: 'black' name: 'ball'" +
                glows + "group: 'both' } } " + emitting_disk(1.5, 2),
       .meters = flux("point") + flux("soft") + flux("spot") + flux("smooth") + flux("linear") +
                 flux("slides") + flux("map") + flux("polygon") + flux("ball") + flux("both") +
                 "meters { name: 'lumens' flux { side: EMITTED light: 'bulb' } } " + flux("lamp"),
       .truths = {24 * kPi, 12 * kPi, 6 * kPi * (1 - std::cos(outer)),
                  6 * kPi * (1 - (std::cos(inner) + std::cos(outer)) / 2), 3 * linear,
                  12 * std::asin(tan * tan / (1 + tan * tan)), 12 * kPi, 2 * kPi * std::sqrt(10.0), kPi * kPi,
                  24 * kPi + 6 * kPi * (1 - std::cos(outer)) + kPi * kPi, 1366, kPi * kPi * 2.25},
       .samples = 16,
       .rounding = 1e-4});
}

TEST(Measure, RefusesTheFluxOfOtherLightsByName) {
  const auto why = [](const std::string& light, const std::string& more = "") {
    return std::string(
        measure_text(
            {.scene = scene_with("lights { name: 'sun' distant { direction { z: -1 } irradiance { rgb "
                                 "{ r: 2 g: 2 b: 2 } } } } " +
                                 emitting_disk(1, 1)),
             .meters = "meters { name: 'm' flux { side: EMITTED light: '" + light + "' " + more + "} }"})
            .status()
            .message());
  };
  using testing::HasSubstr;
  EXPECT_THAT(why("sun"), HasSubstr("light 'sun' shines from infinity: its flux has no end"));
  EXPECT_THAT(why("lamb"), HasSubstr("there is no light or group 'lamb'; did you mean 'lamp'?"));
  EXPECT_THAT(why("lamp", "escaping: true"), HasSubstr("one of them was expected"));
}

/// A ball whose inside glows with a radiance of 1 and reflects a part of all light.
std::string glowing_ball(double reflectance) {
  const std::string rho = number(reflectance);
  return "materials { name: 'paint' diffuse { reflectance { constant { rgb { r: " + rho + " g: " + rho +
         " b: " + rho +
         " } } } } } shapes { sphere { radius: 2 } material: 'paint' name: 'ball' reverse_orientation: true "
         "area_light { radiance { rgb { r: 1 g: 1 b: 1 } } } }";
}

TEST(Measure, ReadsAnIntegratingSphere) {
  // Light of all orders of reflection adds up to pi L / (1 - rho) everywhere [Walsh 1965].
  for (const double rho : {0.5, 0.9, 0.98}) {
    const double all = kPi / (1 - rho);
    expect_measured(
        {.name = "integrating sphere",
         .scene = glowing_ball(rho),
         .meters = point_meter("middle", "", "z: 1") + point_meter("aside", "x: 1", "y: 1") +
                   "meters { name: 'B' unit: 'W/m2' exitance { receivers { surface { shape: 'ball' "
                   "} } } }",
         .truths = {all, all, all}});
  }
}

TEST(Measure, ReadsSurfacesByTriangle) {
  // Under a sky of radiance 1, pi reaches the outside of whatever is convex, and nothing the inside.
  const std::string box =
      "shapes { box { low: [-1,-2,-1] high: [1,2,3] } material: 'black' name: 'box' world_from_object { "
      "elements: [-1,0,0,5, 0,1,0,0, 0,0,2,0, 0,0,0,1] } } ";
  const std::string receiver = " receivers { surface { shape: 'box' by_triangle: true";
  expect_measured({.name = "box",
                   .scene = box + kSky,
                   .meters = "meters { unit: 'W/m2' irradiance {" + receiver + " } } } } ",
                   .truths = std::vector<double>(12, kPi)});
  expect_measured({.name = "inside of a box",
                   .scene = box + kSky,
                   .meters = "meters { unit: 'W/m2' irradiance {" + receiver + " inside: true } } } } ",
                   .truths = std::vector<double>(12, 0)});
  // The whole of a triangle that faces a far lamp, and a ratio of two meters: cos(60 degrees).
  expect_measured(
      {.name = "polygon",
       .scene = "lights { distant { direction { z: -1 } irradiance { rgb { r: 2 g: 2 b: 2 } } } } shapes { "
                "polygon { corners: [0,0,0, 1,0,0, 0,0.5,0.8660254] } material: 'black' name: 'roof' } ",
       .meters =
           "meters { name: 'roof' unit: 'W/m2' irradiance { receivers { surface { shape: 'roof' } } } } " +
           point_meter("flat", "x: 3", "z: 1") + "meters { ratio { of: 'roof' over: 'flat' } }",
       .truths = {1, 2, 0.5}});
}

TEST(Measure, FollowsLambertAndBeer) {
  expect_measured({.name = "fog that absorbs",
                   .scene = std::string(kPoint) +
                            "media { name: 'fog' extinction { constant { rgb { r: 0.5 g: 0.5 b: 0.5 } } } "
                            "albedo { constant { rgb {} } } }",
                   .meters = point_meter("below", "", "z: 1"),
                   .truths = {3.0 / 4 * std::exp(-1.0)},
                   .algorithm = "volpath",
                   .medium = "fog"});
}

TEST(Measure, LightTracingReadsTheSame) {
  expect_measured(
      {.name = "over a wall",
       .scene = glowing_ball(0.5),
       .meters = point_meter("middle", "", "z: 1") + point_meter("around", "x: 0.5", "z: 1", "SPHERE"),
       .truths = {2 * kPi, 8 * kPi},
       .algorithm = "light",
       .samples = 1 << 17});
}

TEST(Measure, WeighsWavelengths) {
  // A sky of 1 W/(m^2 sr nm) at all wavelengths, of which 360 to 830 nm count.
  using photometry::Weighting;
  const auto of_plane = [](Weighting weighting) {
    return kPi * photometry::band_weight(weighting, 360, 830);
  };
  const auto meter = [](const std::string& unit) {
    return "meters { name: '" + unit + "' unit: '" + unit +
           "' irradiance { receivers { point { normal { x: 1 } } } } } ";
  };
  expect_measured(
      {.name = "even spectrum",
       .scene = "lights { infinite { radiance { sampled { wavelengths_nm: [300, 900] values: [1, 1] } } "
                "} } ",
       .meters = meter("lx") + meter("W/m2") + meter("scotopic lx") + meter("melanopic lx"),
       .truths = {of_plane(Weighting::kPhotopic), of_plane(Weighting::kRadiometric),
                  of_plane(Weighting::kScotopic), of_plane(Weighting::kMelanopic)},
       .is_spectral = true,
       .cd_per_m2 = 683 * 106.856895,
       // Observers are tables a nanometre apart, and bands are ten of them wide.
       .rounding = 1e-3});
}

TEST(Measure, BalancesEnergy) {
  // Light that a lamp over a floor emits is absorbed by floor and lamp, or escapes.
  const std::string scene =
      std::string(kPoint) + kSky + emitting_disk(0.5, 1) +
      "materials { name: 'paint' diffuse { reflectance { constant { rgb { r: 0.7 g: 0.7 b: "
      "0.7 } } } } } shapes { disk { radius: 2 } material: 'paint' name: 'floor' } ";
  double chi_square = 0;
  const std::vector<std::uint64_t> seeds = {1, 1001, 2001, 3001};
  for (const std::uint64_t seed : seeds) {
    const auto measured = measure_text({.scene = scene_with(scene),
                                        .meters = "meters { name: 'all' unit: 'W' energy_balance {} }",
                                        .samples = 1 << 15,
                                        .seed = seed});
    ASSERT_TRUE(measured.ok()) << measured.status();
    const std::vector<client::Reading>& readings = measured->meters.front().readings;
    ASSERT_EQ(readings.size(), 6u);  // emitted, three shapes, escaped, residual
    const client::Figure &emitted = readings.front().figure, &residual = readings.back().figure;
    EXPECT_GT(emitted.value, 12 * kPi + kPi * kPi / 4);
    EXPECT_LT(residual.standard_error, 0.01 * emitted.value);
    const double z = residual.value / residual.standard_error;
    chi_square += z * z;
  }
  // Four squares of standard normal variables exceed 23.5 once in 10,000 times.
  EXPECT_LT(chi_square, 23.5);
}

}  // namespace
}  // namespace tessera::test
