// Lights that go through several keys: pictures against the mean of still ones.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "statistical/motion/still_pictures.h"
#include "statistical/reference/lit_things.h"
#include "statistical/reference/picture.h"

namespace tessera::test::light_keys {
namespace {

/// Camera paths, which share light, and paths from lights.
constexpr const char* kIntegrators[] = {"path", "light", "bdpt"};

PictureRequest request_of(const std::string& scene) {
  PictureRequest request;
  request.scene = absl::StrCat(things(kDiffuse), camera(kPerspective), "lights { ", scene, " }");
  request.max_depth = 2;
  request.blobs = light_blobs();
  return request;
}

void expect_mean_of_stills(const std::function<std::string(double)>& still, const std::string& moving,
                           double relative = 3e-3) {
  const Pictures stills = mean_of_stills([&](double time) {
    PictureRequest request = request_of(still(time));
    request.settings = "path_sharing: PATH_SHARING_OFF";
    return request;
  });
  for (const char* const integrator : kIntegrators) {
    SCOPED_TRACE(integrator);
    PictureRequest request = request_of(moving);
    request.integrator = integrator;
    request.spp = samples_of_form(4096);
    expect_same(measure_pictures(request), stills, relative);
  }
}

std::string shifted(double x, double y, double z) {
  return absl::StrFormat("place { elements: [1,0,0,%.15g, 0,1,0,%.15g, 0,0,1,%.15g, 0,0,0,1] } ", x, y, z);
}

TEST(LightKeys, APointGoesRoundACorner) {
  // It is at the corner after a quarter of the time, and stands still during the last quarter.
  for (const char* const radius : {"", "radius: 0.2 "}) {
    const auto at = [&](double x, double y) {
      return absl::StrFormat("point { position { x: %.15g y: %.15g z: 2 } intensity { constant: 6 } %s } ", x,
                             y, radius);
    };
    const auto still = [&](double time) {
      if (time < 0.25) return at(-1 + 8 * time, -1);
      return at(1, time < 0.75 ? -1 + 4 * (time - 0.25) : 1);
    };
    expect_mean_of_stills(still, absl::StrCat(at(-1, -1), "motion { time: 0.25 ", shifted(2, 0, 0),
                                              "} motion { time: 0.75 ", shifted(2, 2, 0), "}"));
  }
}

TEST(LightKeys, ASpotOnAnArmTurnsAllTheWayRound) {
  // Once and a third about the middle of the floor, faster in the second half; it looks outwards and down.
  const auto spot = [](double degrees) {
    const double angle = degrees * std::numbers::pi / 180, c = std::cos(angle), s = std::sin(angle);
    return absl::StrFormat(
        "spot { position { x: %.15g y: %.15g z: 2.5 } target { x: %.15g y: %.15g } intensity { constant: 15 "
        "} "
        "cone_angle_degrees: 35 cone_delta_degrees: 15 } ",
        0.6 * c, 0.6 * s, 1.2 * c, 1.2 * s);
  };
  const std::string turn = "turn { axis { z: 1 } degrees: ";
  // Steps of 300/64 degrees leave the arm by less than a thousandth of it, which nothing warns of.
  expect_mean_of_stills(
      [&](double time) { return spot(time < 0.5 ? 360 * time : 180 + 600 * (time - 0.5)); },
      absl::StrCat(spot(0), "motion { time: 0.5 ", turn, "180 } } motion { time: 1 ", turn, "300 } }"));
}

TEST(LightKeys, ASunAndASkyTurnFurtherThanHalfWay) {
  const auto sun = [](double degrees) {
    const double angle = degrees * std::numbers::pi / 180;
    return absl::StrFormat("distant { direction { x: %.15g y: %.15g z: -1 } irradiance { constant: 2 } } ",
                           0.7 * std::cos(angle), 0.7 * std::sin(angle));
  };
  const auto about_z = [](double degrees) {
    return absl::StrFormat("turn { axis { z: 1 } degrees: %.15g } ", degrees);
  };
  expect_mean_of_stills(
      [&](double time) { return sun(240 * time); },
      absl::StrCat(sun(0), "motion { time: 0.5 ", about_z(120), "} motion { time: 1 ", about_z(120), "}"));

  // The map's own axis of turning is y: about it, the two rows of texels turn.
  const auto sky = [](const std::string& more) {
    return absl::StrCat("infinite { image { digest: 'map' path: 'map.pfm' } mapping: LATITUDE_LONGITUDE ",
                        more, " } ");
  };
  const auto upright = [](double degrees) {
    const double angle = degrees * std::numbers::pi / 180, c = std::cos(angle), s = std::sin(angle);
    // y of the map is z of the world: (x, y, z) goes to (x, -z, y), after a turn about y.
    return absl::StrFormat(
        "world_from_light { elements: [%.15g,0,%.15g,0, %.15g,0,%.15g,0, 0,1,0,0, 0,0,0,1] }", c, s, s, -c);
  };
  expect_mean_of_stills(
      [&](double time) { return sky(upright(300 * time)); },
      absl::StrCat(sky(upright(0)), "motion { time: 1 turn { axis { y: 1 } degrees: 300 } }"));
}

}  // namespace
}  // namespace tessera::test::light_keys
