// Bidirectional path tracing reads probes as path tracing does, and light tracing where that is blind.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "measure_text.h"

namespace tessera::test {
namespace {

constexpr std::uint64_t kSeeds[] = {1, 100001, 200001};

struct Comparison {
  std::string scene;  // besides scene_with()'s
  std::string meters;
  std::string other_meters{};  // of the other integrator; empty: the same
  std::string other = "path";
  std::uint64_t samples = 1 << 14, other_samples = 1 << 14;
  std::string medium{};
  double factor = 1;  // of the other's figures
  double largest_error = 0.05;
};

std::vector<client::Figure> figures_of(const Comparison& test, bool is_other, std::uint64_t seed) {
  const auto measured =
      measure_text({.scene = scene_with(test.scene, test.medium),
                    .meters = is_other && !test.other_meters.empty() ? test.other_meters : test.meters,
                    .algorithm = is_other ? test.other : "bdpt",
                    .samples = is_other ? test.other_samples : test.samples,
                    .seed = seed});
  EXPECT_TRUE(measured.ok()) << measured.status();
  std::vector<client::Figure> figures;
  if (!measured.ok()) return figures;
  for (const client::MeasuredMeter& meter : measured->meters)
    for (const client::Reading& reading : meter.readings) figures.push_back(reading.figure);
  return figures;
}

/// Means over seeds differ by less than five of their standard errors, and these are small.
void expect_same(const Comparison& test) {
  std::vector<double> a, b, variance;
  for (const std::uint64_t seed : kSeeds) {
    const std::vector<client::Figure> ours = figures_of(test, false, seed),
                                      theirs = figures_of(test, true, seed + 50000);
    ASSERT_EQ(ours.size(), theirs.size());
    ASSERT_FALSE(ours.empty());
    a.resize(ours.size()), b.resize(ours.size()), variance.resize(ours.size());
    for (std::size_t i = 0; i < ours.size(); ++i) {
      a[i] += ours[i].value, b[i] += test.factor * theirs[i].value;
      variance[i] += ours[i].standard_error * ours[i].standard_error +
                     test.factor * test.factor * theirs[i].standard_error * theirs[i].standard_error;
    }
  }
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double error = std::sqrt(variance[i]);
    EXPECT_LE(error, test.largest_error * std::max(std::abs(b[i]), 1e-3)) << i;
    EXPECT_NEAR(a[i], b[i], 5 * error + 1e-5 * std::abs(b[i])) << i << ": " << (a[i] - b[i]) / error;
  }
}

std::string meter_at(const std::string& position, const std::string& shape, const std::string& more = "") {
  return absl::StrCat("meters { irradiance { shape: ", shape, " ", more, " receivers { point { position { ",
                      position, " } normal { z: 1 } } } } } ");
}

/// Points of all kinds, a plane, a surface, rays, and the net flux through a plane.
std::string all_kinds() {
  std::string meters;
  for (const char* const shape : {"PLANE", "SPHERE", "CYLINDER", "HALF_SPHERE"})
    meters += meter_at("x: -0.4 y: 0.1", shape);
  return absl::StrCat(
      meters, meter_at("x: -0.4 y: 0.1", "HALF_CYLINDER", "front { x: 1 }"),
      "meters { irradiance { receivers { plane { corner { x: -1 y: -1 } edge_u { x: 2 } edge_v { y: 2 } "
      "columns: 2 } } } } "
      "meters { irradiance { receivers { surface { shape: 'ball' } } } } "
      "meters { exitance { receivers { surface { shape: 'ball' } } } } "
      "meters { radiance { ray { from { x: -1 z: 1 } toward { x: 0.8 } } } } "
      "meters { radiance { ray { from { x: -1 z: 1 } toward { x: 0.8 } field_degrees: 40 } } } "
      "meters { flux { receivers { plane { corner { x: -1 y: -1 z: 1.5 } edge_u { x: 2 } edge_v { y: 2 } } } "
      "} } ");
}

const char* const kBallOnFloor = R"(
    materials { name: 'paint' diffuse { reflectance { constant { rgb { r: .7 g: .6 b: .5 } } } } }
    shapes { sphere { radius: 0.5 } material: 'paint' name: 'ball'
             world_from_object { elements: [1,0,0,0.8, 0,1,0,0, 0,0,1,0.2, 0,0,0,1] } }
    shapes { disk { radius: 4 } material: 'paint' name: 'floor'
             world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-0.5, 0,0,0,1] } } )";
const char* const kLampOfDisk = R"(
    shapes { disk { radius: 0.3 } material: 'black' area_light { radiance { rgb { r: 20 g: 20 b: 20 } } }
             world_from_object { elements: [1,0,0,0, 0,-1,0,0, 0,0,-1,2.5, 0,0,0,1] } } )";
const char* const kLampAtPoint =
    "lights { point { position { x: 0.3 z: 2 } intensity { rgb { r: 3 g: 3 b: 3 } } } } ";
const char* const kSkyAndSun =
    "lights { infinite { radiance { rgb { r: 1 g: 1 b: 1 } } } } "
    "lights { distant { direction { x: 0.2 z: -1 } irradiance { rgb { r: 2 g: 2 b: 2 } } } } ";
const char* const kGlassBall = R"(
    materials { name: 'glass' dielectric { eta { constant: 1.5 } } }
    shapes { sphere { radius: 0.4 } material: 'glass'
             world_from_object { elements: [1,0,0,-0.4, 0,1,0,0, 0,0,1,0.8, 0,0,0,1] } } )";

TEST(BidirectionalProbes, ReadLampsOfSomeSize) {
  expect_same({.scene = absl::StrCat(kBallOnFloor, kLampOfDisk), .meters = all_kinds()});
}

TEST(BidirectionalProbes, ReadLampsAtPoints) {
  expect_same({.scene = absl::StrCat(kBallOnFloor, kLampAtPoint), .meters = all_kinds()});
}

TEST(BidirectionalProbes, ReadSkiesAndTheSun) {
  expect_same({.scene = absl::StrCat(kBallOnFloor, kSkyAndSun), .meters = all_kinds()});
}

TEST(BidirectionalProbes, ReadCausticsOfLampsOfSomeSize) {
  expect_same({.scene = absl::StrCat(kBallOnFloor, kLampOfDisk, kGlassBall),
               .meters = all_kinds(),
               .other_samples = 1 << 16,
               .largest_error = 0.1});
}

TEST(BidirectionalProbes, ReadFog) {
  const char* const fog =
      "media { name: 'fog' extinction { constant { rgb { r: 0.3 g: 0.4 b: 0.5 } } } "
      "albedo { constant { rgb { r: 0.8 g: 0.8 b: 0.8 } } } } ";
  for (const char* const lamp : {kLampOfDisk, kLampAtPoint}) {
    expect_same({.scene = absl::StrCat(kBallOnFloor, lamp, fog),
                 .meters = all_kinds(),
                 .other = "volpath",
                 .medium = "fog"});
  }
}

TEST(BidirectionalProbes, ReadFromWithinACloud) {
  // All points are in it, the camera and the lamps are not.
  const char* const cloud = R"(
    media { name: 'cloud' extinction { constant { rgb { r: 3 g: 4 b: 5 } } }
            albedo { constant { rgb { r: 0.8 g: 0.8 b: 0.8 } } } }
    materials { name: 'open' interface {} }
    shapes { sphere { radius: 0.3 } material: 'open' interior_medium: 'cloud'
             world_from_object { elements: [1,0,0,-0.4, 0,1,0,0.1, 0,0,1,0, 0,0,0,1] } } )";
  for (const char* const lamp : {kLampOfDisk, kLampAtPoint})
    expect_same(
        {.scene = absl::StrCat(kBallOnFloor, lamp, cloud), .meters = all_kinds(), .other = "volpath"});
}

TEST(BidirectionalProbes, ReadCausticsOfPointsOnSurfaces) {
  // A floor of reflectance 1/2 sends back half of what reaches it, with a caustic that path tracing never
  // finds.
  const std::string scene = absl::StrCat(
      kGlassBall, kLampAtPoint,
      "materials { name: 'grey' diffuse { reflectance { constant { rgb { r: .5 g: .5 b: .5 } } } } } "
      "shapes { disk { radius: 0.6 } material: 'grey' name: 'floor' world_from_object { elements: "
      "[1,0,0,-0.6, "
      "0,1,0,0, 0,0,1,-0.5, 0,0,0,1] } } ");
  const std::string receivers = " receivers { surface { shape: 'floor' } } } } ";
  expect_same({.scene = scene,
               .meters = absl::StrCat("meters { exitance {", receivers),
               .other_meters = absl::StrCat("meters { irradiance {", receivers),
               .other = "light",
               .samples = 1 << 15,
               .other_samples = 1 << 17,
               .factor = 0.5});
}

TEST(BidirectionalProbes, ChosenIntegratorsReadTheSame) {
  // The lamp is behind a screen: paths from the floor hardly meet what it lights.
  const std::string scene = absl::StrCat(
      kBallOnFloor, kLampAtPoint,
      "shapes { disk { radius: 1 } material: 'paint' world_from_object { elements: [1,0,0,0.3, 0,1,0,0, "
      "0,0,1,1.95, 0,0,0,1] } } ");
  MeasureRequest request{.scene = scene_with(scene),
                         .meters = meter_at("x: -0.4 y: 0.1", "PLANE") + meter_at("x: 3 z: 3", "SPHERE") +
                                   "meters { exitance { receivers { surface { shape: 'ball' } } } } ",
                         .samples = 1 << 14,
                         .integrators = {"path", "bdpt", "light"}};
  std::vector<double> difference(3), variance(3);
  for (const std::uint64_t seed : kSeeds) {
    request.seed = seed, request.threads = 1;
    const auto chosen = measure_text(request);
    ASSERT_TRUE(chosen.ok()) << chosen.status();
    request.threads = 3;
    const auto again = measure_text(request);
    ASSERT_TRUE(again.ok()) << again.status();
    MeasureRequest usual = request;
    usual.integrators.clear(), usual.seed += 50000;
    const auto by_paths = measure_text(usual);
    ASSERT_TRUE(by_paths.ok()) << by_paths.status();
    for (std::size_t m = 0; m < 3; ++m) {
      const client::Figure &a = chosen->meters[m].readings[0].figure,
                           &b = by_paths->meters[m].readings[0].figure;
      EXPECT_EQ(chosen->meters[m].algorithm, again->meters[m].algorithm);
      EXPECT_EQ(a.value, again->meters[m].readings[0].figure.value);
      EXPECT_EQ(a.samples, std::uint64_t{1} << 14);
      difference[m] += a.value - b.value;
      variance[m] += a.standard_error * a.standard_error + b.standard_error * b.standard_error;
    }
    EXPECT_NE(chosen->meters[2].algorithm, "light") << "which does not read what leaves a surface";
  }
  for (std::size_t m = 0; m < 3; ++m)
    EXPECT_LE(std::abs(difference[m]), 5 * std::sqrt(variance[m])) << m << " of " << request.meters;
}

}  // namespace
}  // namespace tessera::test
