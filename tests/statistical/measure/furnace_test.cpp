// Light that is the same everywhere, or follows from one law: furnaces, fog, and clear glass.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "agreement.h"
#include "scene_text.h"
#include "support/light/closed_forms.h"

namespace tessera::test {
namespace {

constexpr double kGlass = 1.5;

std::string glass_text() {
  return absl::StrCat("materials { name: 'glass' dielectric { eta { constant: ", kGlass, " } } } ");
}

/// A room whose walls glow and reflect, each in its own way, such that the radiance within is 1: a wall of
/// reflectance rho has a radiance of 1 - rho of its own.
std::string furnace_room() {
  const Room room = {{-2, -2, -2}, {2, 2, 2}};
  std::string text;
  for (std::size_t number = 0; number < 6; ++number) {
    const double rho = 0.2 + 0.12 * static_cast<double>(number);
    const std::string paint = absl::StrCat("paint", number);
    const Room::Wall wall = room.wall(number);
    text += diffuse(paint, rho) + panel(wall.corner, wall.edge_u, wall.edge_v, glow(1 - rho), paint);
  }
  return text;
}

/// Things in that room that take away no light, or give back what they take: a ball that glows, a ball of
/// glass, and a mirror.
std::string furnace_things() {
  return diffuse("dull", 0.3) + sphere_text(0.5, {0.8, 0.8, -1}, "name: 'dull ball' " + glow(0.7), "dull") +
         glass_text() + sphere_text(0.6, {-0.9, 0.5, 0}, "", "glass") +
         "materials { name: 'mirror' conductor { reflectance { constant { rgb { r: 1 g: 1 b: 1 } } } } } " +
         panel({-1, -1.5, -1}, {2, 0, 0}, {0, 0.4, 1}, "", "mirror");
}

/// Adds meters and their truths in a furnace of radiance 1: in the open, on the ball, and along rays to wall,
/// balls and mirror.
void add_furnace_meters(MeasuredCase& test) {
  const auto add = [&](const std::string& meter, double truth) {
    test.meters += meter;
    test.truths.push_back(truth);
  };
  const std::string middle = point_at({0, 0, 0.3}, {0, 0.6, 0.8});
  add(irradiance_meter("plane", middle), forms::kPi);
  add(irradiance_meter("all around", middle, "SPHERE"), 4 * forms::kPi);
  add(irradiance_meter("cylinder", middle, "CYLINDER"), forms::kPi);
  add(irradiance_meter("half of a ball", middle, "HALF_SPHERE"), forms::kPi);
  add(irradiance_meter("cell", plane_receiver({-1, -1, 1}, {2, 0, 0}, {0, 2, 0})), forms::kPi);
  add("meters { name: 'B' unit: 'W/m2' exitance { " + surface_receiver("dull ball") + "} } ",
      forms::exitance_of_radiance(1));
  add(ray_meter("wall", {0, 0, 0}, {2, 1, 1}), 1);
  add(ray_meter("dull ball", {0, 0, 0}, {0.8, 0.8, -1}), 1);
  add(ray_meter("glass ball", {1.5, 0, 0}, {-0.9, 0.6, 0.1}), 1);
  add(ray_meter("mirror", {0, 0, 0.5}, {0.3, -1.3, -0.5}), 1);
}

TEST(Furnace, ARoomIsEvenlyBright) {
  MeasuredCase bare{.name = "walls", .scene = furnace_room() + furnace_things(), .samples = 1 << 15};
  add_furnace_meters(bare);
  // Radiance grows by the square of the index where light enters glass, and what is read there is as much
  // more.
  const std::string within = point_at({-0.9, 0.4, 0.1}, {0, 0.6, 0.8});
  bare.meters +=
      irradiance_meter("in glass", within, "SPHERE") + ray_meter("in glass", {-0.9, 0.5, 0}, {-0.9, 2, 0.3});
  for (const double of_one : {4 * forms::kPi, 1.0})
    bare.truths.push_back(forms::radiance_in_medium(of_one, kGlass));
  expect_agreement({bare});
}

TEST(Furnace, FogThatOnlyScattersChangesNothing) {
  MeasuredCase fog{.name = "fog",
                   .scene = furnace_room() + furnace_things() +
                            "media { name: 'fog' extinction { constant { " + grey(0.8) +
                            " } } albedo { constant { " + grey(1) + " } } g: 0.4 } ",
                   .algorithm = "volpath",
                   .samples = 1 << 14,
                   .medium = "fog"};
  add_furnace_meters(fog);
  expect_agreement({fog});
}

TEST(Furnace, FogThatGlowsAsMuchAsItTakesChangesNothing) {
  // The part of extinction that is absorbed, .7, is emitted again.
  MeasuredCase fog{.name = "fog",
                   .scene = furnace_room() + "media { name: 'fog' extinction { constant { " + grey(0.8) +
                            " } } albedo { constant { " + grey(0.3) + " } } emission { constant { " +
                            grey(1) + " } } } ",
                   .algorithm = "volpath",
                   .samples = 1 << 14,
                   .medium = "fog"};
  fog.meters = irradiance_meter("plane", point_at({0, 0, 0.3}, {0, 0.6, 0.8})) +
               ray_meter("wall", {0, 0, 0}, {2, 1, 1});
  fog.truths = {forms::kPi, 1};
  expect_agreement({fog});
}

/// A square of 20 m in z = 0 with a radiance of 1, which looks up.
std::string bright_floor() { return panel({-10, -10, 0}, {20, 0, 0}, {0, 20, 0}, glow()); }

TEST(Rays, RadianceStaysTheSame) {
  MeasuredCase test{.name = "ray", .scene = bright_floor()};
  for (const double away : {0.01, 1.0, 100.0, 10000.0}) {
    test.meters += ray_meter("straight", {0.3, 0.1, away}, {0.3, 0.1, 0});
    test.meters += ray_meter("aslant", {away, 0, away}, {0, 0.5, 0});
    test.truths.insert(test.truths.end(), 2, 1.0);
  }
  expect_agreement({test});
}

TEST(Rays, FogTakesAPartThatFollowsLambertAndBeer) {
  MeasuredCase test{.name = "fog",
                    .scene = bright_floor() + "media { name: 'fog' extinction { constant { " + grey(0.5) +
                             " } } albedo { constant { " + grey(0) + " } } } ",
                    .algorithm = "volpath",
                    .medium = "fog",
                    .largest_error = 0.01};
  // Away from the floor's diagonal: it is made of two triangles, and the fast test of rays may let one that
  // is aimed at their common edge through.
  const Point target = {0.3, 0.1, 0};
  for (const double away : {0.1, 1.0, 2.0, 5.0}) {
    test.meters += ray_meter("straight", {0.3, 0.1, away}, target) +
                   ray_meter("aslant", {0.3 + away, 0.1, away}, target);
    test.truths.insert(test.truths.end(),
                       {forms::transmittance(0.5, away), forms::transmittance(0.5, away * std::sqrt(2.0))});
  }
  expect_agreement({test});
}

/// A ball of smoke that takes light and scatters none, 1 m in radius and of extinction 1 about `middle`,
/// whose border bends no light.
std::string ball_of_smoke(const Point& middle) {
  return absl::StrCat("media { name: 'smoke' extinction { constant { ", grey(1), " } } albedo { constant { ",
                      grey(0), " } } } materials { name: 'open' interface {} } ",
                      sphere_text(1, middle, "interior_medium: 'smoke' ", "open"));
}

TEST(Rays, MetersAreInTheMediumAtTheirPlace) {
  const std::string sky = "lights { infinite { radiance { " + grey(1) + " } } } ";
  const auto left_after = [](double metres) { return forms::transmittance(1, metres); };
  // The camera, at the origin, is outside.
  MeasuredCase within{.name = "meters in smoke",
                      .scene = ball_of_smoke({5, 0, 0}) + sky,
                      .algorithm = "volpath",
                      .largest_error = 0.02};
  const std::string middle = point_at({5, 0, 0}, {0.6, 0, 0.8});
  within.meters = irradiance_meter("plane", middle) + irradiance_meter("all around", middle, "SPHERE") +
                  ray_meter("out of it", {5.5, 0, 0}, {9, 0, 0}) +
                  ray_meter("through it", {5.5, 0, 0}, {4, 0, 0}) +
                  ray_meter("across", {2, 0, 0}, {9, 0, 0}) + ray_meter("aside", {2, 0, 0}, {2, 1, 0});
  within.truths = {forms::kPi * left_after(1),
                   4 * forms::kPi * left_after(1),
                   left_after(0.5),
                   left_after(1.5),
                   left_after(2),
                   1};
  // The camera is in it, and most meters are not.
  MeasuredCase around{.name = "camera in smoke",
                      .scene = ball_of_smoke({0, 0, 0}) + sky,
                      .algorithm = "volpath",
                      .medium = "smoke",
                      .largest_error = 0.02};
  around.meters = ray_meter("out of it", {0, 0, 0}, {9, 0, 0}) + ray_meter("aside", {3, 0, 0}, {3, 1, 0}) +
                  ray_meter("across", {3, 0, 0}, {-9, 0, 0});
  around.truths = {left_after(1), 1, left_after(2)};
  // A lamp within, whose light is sampled at the meters.
  MeasuredCase lamp{.name = "lamp in smoke",
                    .scene = ball_of_smoke({5, 0, 0}) + "lights { point { position { x: 5 } intensity { " +
                             grey(2) + " } } } ",
                    .algorithm = "volpath",
                    .rounding = kMargin,
                    .largest_error = 0.02};
  lamp.meters = irradiance_meter("far", point_at({8, 0, 0}, {-1, 0, 0})) +
                irradiance_meter("near", point_at({5.5, 0, 0}, {-1, 0, 0}));
  lamp.truths = {2 * left_after(1) / 9, 2 * left_after(0.5) / 0.25};
  for (const char* const algorithm : {"volpath", "bdpt"}) {
    for (MeasuredCase* const test : {&within, &around, &lamp}) test->algorithm = algorithm;
    expect_agreement({within, around, lamp});
  }
}

/// Reflectance of one face of glass, of unpolarised light [Fresnel 1823].
double face_reflectance(double cosine) {
  const double inner = std::sqrt(1 - (1 - cosine * cosine) / (kGlass * kGlass));
  const double s = (cosine - kGlass * inner) / (cosine + kGlass * inner),
               p = (kGlass * cosine - inner) / (kGlass * cosine + inner);
  return (s * s + p * p) / 2;
}

TEST(Rays, ClearGlass) {
  // CIE 171:2006, 5.5: transmittance by direction. The report has measured figures of 6 mm glass; here it is
  // a solid slab without absorption, and a pane without thickness, and both are Fresnel's: (1 - r) / (1 + r),
  // with all inner reflections.
  MeasuredCase slab{.name = "slab",
                    .scene = bright_floor() + glass_text() +
                             shape_text("box { low: [-9, -9, 1] high: [9, 9, 1.2] }", "", "glass"),
                    .samples = 1 << 17};
  MeasuredCase pane{
      .name = "pane",
      .scene = bright_floor() + panel({-9, -9, 1}, {18, 0, 0}, {0, 18, 0}, "", "pane") +
               absl::StrCat("materials { name: 'pane' thin_dielectric { eta { constant: ", kGlass, " } } } "),
      .samples = 1 << 17};
  for (const double degrees : {0.0, 20.0, 40.0, 60.0, 75.0}) {
    const double angle = degrees * forms::kPi / 180, r = face_reflectance(std::cos(angle));
    const double through = degrees == 0 ? forms::transmittance_of_plate(kGlass) : (1 - r) / (1 + r);
    for (MeasuredCase* test : {&slab, &pane}) {
      test->meters += ray_meter(absl::StrCat(degrees, " degrees"), {0, 0, 2}, {std::tan(angle), 0, 1});
      test->truths.push_back(through);
    }
  }
  // In the slab, looking down: (1 - r) n^2 comes in, and again r^2 of it after two reflections.
  slab.meters += ray_meter("in the slab", {0, 0, 1.1}, {0, 0, 0});
  slab.truths.push_back(forms::radiance_in_medium(1, kGlass) / (1 + face_reflectance(1)));
  expect_agreement({slab, pane});
}

}  // namespace
}  // namespace tessera::test
