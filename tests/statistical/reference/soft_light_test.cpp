// Point and spot lights with a radius: the light of a sphere that nothing shows and that throws no shadow.
#include <gtest/gtest.h>

#include <numbers>
#include <string>

#include "absl/strings/str_cat.h"
#include "statistical/reference/lit_things.h"
#include "statistical/reference/picture.h"

namespace tessera::test::soft_light {
namespace {

constexpr double kPi = std::numbers::pi;

/// White paint in the middle of a picture that is so narrow that all of it has one irradiance.
PictureRequest white_floor(const std::string& lights) {
  PictureRequest request;
  request.scene = absl::StrCat(
      "camera { perspective { fov_degrees: 0.01 } world_from_camera { elements: [1,0,0,0, 0,-1,0,0, "
      "0,0,-1,6, "
      "0,0,0,1] } } materials { name: 'white' diffuse { reflectance { constant { constant: 1 } } } } "
      "shapes { disk { radius: 3 } material: 'white' } ",
      lights);
  request.max_depth = 1;
  request.spp = 256;
  return request;
}

std::string point(double z, double intensity, double radius) {
  return absl::StrCat("lights { point { position { z: ", z, " } intensity { constant: ", intensity,
                      " } radius: ", radius, " } } ");
}

TEST(SoftLight, IsAGlowingSphereForWhatItShinesOn) {
  // Outside of the picture. Of light that is scattered once, the sphere's surface stops none.
  constexpr double kRadius = 0.4, kRadiance = 20;
  PictureRequest request;
  request.scene =
      things(kDiffuse) + camera(kPerspective) +
      absl::StrCat("shapes { sphere { radius: ", kRadius, " } area_light { radiance { constant: ", kRadiance,
                   " } } world_from_object { elements: [1,0,0,0.5, 0,1,0,-1, 0,0,1,3.2, 0,0,0,1] } }");
  request.blobs = light_blobs();
  request.max_depth = 1;
  request.spp = samples_of_form(1024);
  const Picture sphere = measure_picture(request);
  ASSERT_FALSE(sphere.values.empty());
  EXPECT_LT(sphere.whole(1).error, noise_of_form(0.005) * sphere.whole(1).mean);
  request.scene = things(kDiffuse) + camera(kPerspective) +
                  absl::StrCat("lights { point { position { x: 0.5 y: -1 z: 3.2 } radius: ", kRadius,
                               " intensity { constant: ", kPi * kRadius * kRadius * kRadiance, " } } }");
  struct Integrator {
    const char* name;
    const char* settings = "";
  };
  for (const Integrator& integrator :
       {Integrator{"path"}, Integrator{"volpath"}, Integrator{"direct"}, Integrator{"whitted"},
        Integrator{"raycast"}, Integrator{"guided"}, Integrator{"irradiance-cache"}, Integrator{"light"},
        Integrator{"bdpt"}, Integrator{"mlt", "mlt { mutations: 32 }"}}) {
    SCOPED_TRACE(integrator.name);
    request.integrator = integrator.name;
    request.settings = integrator.settings;
    const Picture soft = measure_picture(request);
    ASSERT_FALSE(soft.values.empty());
    EXPECT_LT(soft.whole(1).error, noise_of_form(0.02) * soft.whole(1).mean);
    expect_same(sphere, soft);
  }
}

TEST(SoftLight, ThrowsNoShadow) {
  // One above the other above the floor, and the camera above them all.
  const std::string lights = point(1, 2, 0.4) + point(2.2, 3, 0.5) + point(4, 7, 0);
  const double irradiance = 2 + 3 / (2.2 * 2.2) + 7 / 16.0;
  for (const char* const integrator : {"path", "volpath", "whitted", "bdpt"}) {
    SCOPED_TRACE(integrator);
    PictureRequest request = white_floor(lights);
    request.integrator = integrator;
    expect_value(measure_picture(request), irradiance / kPi);
  }
}

TEST(SoftLight, ShinesOnWhatStandsInIt) {
  // The floor goes through it: the wall above the floor, of half of the radiance that is seen from outside.
  for (const char* const integrator : {"path", "bdpt"}) {
    PictureRequest request = white_floor(point(0.3, 2, 0.8));
    request.integrator = integrator;
    expect_value(measure_picture(request), 2 / (2 * 0.8 * 0.8) / kPi);
  }
}

TEST(SoftLight, IsShownByNothing) {
  // Seen from within, from outside, in a mirror and through glass.
  for (const double z : {6.0, 2.0}) {
    for (const char* const material : {"conductor { reflectance { constant { constant: 0.9 } } }",
                                       "dielectric { eta { constant: 1.5 } }"}) {
      for (const char* const integrator : {"path", "whitted", "bdpt"}) {
        SCOPED_TRACE(absl::StrCat(integrator, " ", material, " ", z));
        PictureRequest request;
        request.scene = absl::StrCat(
            "camera { perspective { fov_degrees: 60 } world_from_camera { elements: "
            "[1,0,0,0, 0,-1,0,0, 0,0,-1,",
            z, ", 0,0,0,1] } } materials { name: 'm' ", material,
            " } shapes { disk { radius: 2 } material: 'm' }", point(2, 5, 1));
        request.integrator = integrator;
        request.spp = 64;
        const Picture picture = measure_picture(request);
        ASSERT_FALSE(picture.values.empty());
        EXPECT_EQ(picture.whole(1).mean, 0);
      }
    }
  }
}

}  // namespace
}  // namespace tessera::test::soft_light
