// Balances of light: what is emitted is absorbed, or escapes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "agreement.h"
#include "measure_text.h"
#include "scene_text.h"

namespace tessera::test {
namespace {

using testing::HasSubstr;

constexpr const char* kBalance = "meters { name: 'all' unit: 'W' energy_balance {} }";

std::string labels_of(const client::MeasuredMeter& meter) {
  std::string labels;
  for (const client::Reading& reading : meter.readings)
    absl::StrAppend(&labels, labels.empty() ? "" : ", ", reading.label);
  return labels;
}

/// Only what is balanced: rays through a scene with something far away hardly ever meet what it holds.
std::string balanced(const std::string& things, const std::string& medium = "") {
  return absl::StrCat("camera { medium: '", medium, "' orthographic {} } film { width: 1 height: 1 } ",
                      "units { metres: 1 } ", diffuse("black", 0), things);
}

/// Balances a scene by four seeds, all figures of which `look` looks at. The last one is `rest` in the mean:
/// four squares of standard normal variables exceed 23.5 once in 10,000 times.
void expect_balance(const std::string& scene, double rest, const std::string& labels,
                    const std::function<void(const client::MeasuredMeter&)>& look,
                    const std::string& algorithm = "path") {
  double chi_square = 0;
  for (const std::uint64_t seed : {1, 1001, 2001, 3001}) {
    const auto measured = measure_text({.scene = balanced(scene),
                                        .meters = kBalance,
                                        .algorithm = algorithm,
                                        .samples = 1 << 15,
                                        .seed = seed});
    ASSERT_TRUE(measured.ok()) << measured.status();
    const client::MeasuredMeter& meter = measured->meters.front();
    ASSERT_EQ(labels_of(meter), labels);
    look(meter);
    const client::Figure &emitted = meter.readings.front().figure, &last = meter.readings.back().figure;
    EXPECT_LT(last.standard_error, 0.02 * emitted.value);
    // Shadow rays end before lamps by a margin.
    const double z = (last.value - rest) / std::max(last.standard_error, 2 * kMargin * emitted.value);
    chi_square += z * z;
  }
  EXPECT_LT(chi_square, 23.5);
}

std::string lamp_at(const Point& place) {
  return "lights { point { position { " + text_of(place) + " } intensity { " + grey(3) + " } } } ";
}
constexpr double kLampFlux = 12 * forms::kPi;

std::string floor_text() {
  return diffuse("paint", 0.7) + shape_text("disk { radius: 2 }", "name: 'floor'", "paint");
}

TEST(Balance, OfLampsSkyAndASurfaceThatShines) {
  expect_balance("lights { infinite { radiance { " + grey(1) + " } } } " + lamp_at({0, 0, 2}) + floor_text() +
                     disk_text(0.5, {0, 0, 1}, {0, 0, -1}, "name: 'lamp' " + glow()),
                 0, "emitted, absorbed by floor, absorbed by lamp, escaped, residual",
                 [](const client::MeasuredMeter& meter) {
                   EXPECT_GT(meter.readings.front().figure.value, kLampFlux + forms::kPi * forms::kPi / 4);
                 });
}

TEST(Balance, OfLampsThatShineInPart) {
  const std::string spot = "lights { spot { position { x: 0.3 z: 2 } target { x: 0.1 } intensity { " +
                           grey(5) + " } cone_angle_degrees: 30 cone_delta_degrees: 10 } } ";
  expect_balance(
      spot + floor_text(), 0, "emitted, absorbed by floor, escaped, residual",
      [](const client::MeasuredMeter& meter) { EXPECT_EQ(meter.readings.front().figure.standard_error, 0); });
}

TEST(Balance, OfInstances) {
  // Two lamps on stands in a pair, and one that is mirrored and twice as large: six times the area.
  const std::string objects = absl::StrCat(
      "objects { name: 'stand' shapes { disk { radius: 0.25 } reverse_orientation: true material: 'black' ",
      glow(5),
      " } shapes { sphere { radius: 0.3 } material: 'paint' world_from_object { elements: [1,0,0,0, 0,1,0,0, "
      "0,0,1,-0.5, 0,0,0,1] } } } "
      "objects { name: 'pair' "
      "instances { object: 'stand' world_from_instance { elements: [1,0,0,-1, 0,1,0,0, 0,0,1,0, 0,0,0,1] } } "
      "instances { object: 'stand' world_from_instance { elements: [0,0,1,1, 0,1,0,0, -1,0,0,0, 0,0,0,1] } } "
      "} "
      "instances { object: 'pair' world_from_instance { elements: [0,-1,0,0, 1,0,0,0, 0,0,1,1, 0,0,0,1] } } "
      "instances { object: 'stand' world_from_instance { elements: [-2,0,0,2.5, 0,2,0,0, 0,0,2,2, 0,0,0,1] } "
      "} ");
  const double flux = 6 * forms::kPi * 0.25 * 0.25 * forms::kPi * 5;
  expect_balance(floor_text() + objects, 0,
                 "emitted, absorbed by floor, absorbed by pair, absorbed by stand, escaped, "
                 "residual",
                 [&](const client::MeasuredMeter& meter) {
                   const client::Figure& emitted = meter.readings.front().figure;
                   EXPECT_NEAR(emitted.value, flux, 5 * emitted.standard_error + 1e-5 * flux);
                   EXPECT_GT(meter.readings[2].figure.value, 0.005 * flux);
                   EXPECT_GT(meter.readings[3].figure.value, 0.005 * flux);
                 });
}

std::string ball_of(const std::string& medium, const Point& middle) {
  return "materials { name: 'gap' interface {} } " +
         sphere_text(1, middle, "name: 'border' interior_medium: '" + medium + "' ", "gap");
}
std::string medium_of_albedo(double albedo, const std::string& more = "") {
  return "media { name: 'mist' extinction { constant { " + grey(1) + " } } albedo { constant { " +
         grey(albedo) + " } } " + more + "} ";
}

TEST(Balance, OfMedia) {
  const auto look = [](const client::MeasuredMeter& meter) {
    EXPECT_NEAR(meter.readings.front().figure.value, kLampFlux, 1e-5 * kLampFlux);
    ASSERT_FALSE(meter.warnings.empty());
    EXPECT_THAT(meter.warnings.front(), HasSubstr("left over: in media"));
  };
  const std::string lamp = lamp_at({5, 0, 0});
  const double left = forms::transmittance(1, 1);
  expect_balance(medium_of_albedo(0) + ball_of("mist", {5, 0, 0}) + lamp, kLampFlux * (1 - left),
                 "emitted, escaped, absorbed elsewhere", look, "volpath");
  // A medium that only scatters takes nothing, over a floor that does.
  expect_balance(
      medium_of_albedo(1) + ball_of("mist", {5, 0, 0}) + lamp + diffuse("paint", 0.5) +
          shape_text("disk { radius: 2 }", "name: 'floor' " + placed({5, 0, -1.5}, {0, 0, 1}), "paint"),
      0, "emitted, absorbed by floor, escaped, absorbed elsewhere", look, "volpath");
}

TEST(Balance, TellsWhatItDoesNotRead) {
  // A part of a sphere takes what is left over.
  const auto measured =
      measure_text({.scene = balanced(lamp_at({0, 0, 0.5}) + floor_text() +
                                      shape_text("sphere { radius: 1 z_min: 0 z_max: 1 }",
                                                 "name: 'dome' " + placed({0, 0, 1}, {0, 0, 1}))),
                    .meters = kBalance});
  ASSERT_TRUE(measured.ok()) << measured.status();
  const client::MeasuredMeter& meter = measured->meters.front();
  ASSERT_FALSE(meter.warnings.empty());
  EXPECT_THAT(meter.warnings.front(), HasSubstr("by 'dome' (it is a part of a sphere"));
  const double rest = meter.readings.back().figure.value;
  EXPECT_GT(rest, 0.05 * kLampFlux);
  EXPECT_LT(rest, 0.95 * kLampFlux);
}

TEST(Balance, RefusesWhatItCannotKnow) {
  const auto why = [](const std::string& scene, const std::string& medium = "") {
    return std::string(
        measure_text({.scene = balanced(scene, medium), .meters = kBalance, .algorithm = "volpath"})
            .status()
            .message());
  };
  EXPECT_THAT(why(medium_of_albedo(0, "emission { constant { " + grey(1) + " } } ")),
              HasSubstr("medium 'mist' glows"));
  EXPECT_THAT(why(medium_of_albedo(0), "mist"), HasSubstr("the camera is in medium 'mist'"));
  EXPECT_THAT(why(shape_text("sphere { radius: 1 z_min: 0 z_max: 1 }", "name: 'dome' " + glow())),
              HasSubstr("'dome' (it is a part of a sphere: only whole ones are read) emits light"));
}

}  // namespace
}  // namespace tessera::test
