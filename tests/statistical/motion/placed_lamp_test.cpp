// Lamps in objects that instances place, standing and moving, against lamps of the world.
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "absl/strings/str_cat.h"
#include "statistical/motion/still_pictures.h"
#include "statistical/reference/lit_things.h"
#include "statistical/reference/picture.h"

namespace tessera::test::placed_lamp {
namespace {

struct Integrator {
  const char* name;
  const char* settings = "";
};

/// Those that find light in different ways, and levels that are kept and flattened.
constexpr Integrator kIntegrators[] = {
    {"path"},
    {"path", "direct_light: DIRECT_LIGHT_BSDF nesting: NESTING_KEPT"},
    {"path", "nesting: NESTING_KEPT light_selection: LIGHT_SELECTION_TREE"},
    {"volpath"},
    {"light", "nesting: NESTING_KEPT"},
    {"bdpt"},
    {"mlt", "mlt { mutations: 32 }"}};

PictureRequest request_of(const std::string& scene) {
  PictureRequest request;
  request.scene = absl::StrCat(things(kDiffuse), camera(kPerspective), scene);
  request.max_depth = 2;
  request.blobs = light_blobs();
  return request;
}

void expect_all(const std::string& scene, const Pictures& expected, double relative) {
  for (const Integrator& integrator : kIntegrators) {
    SCOPED_TRACE(absl::StrCat(integrator.name, " ", integrator.settings));
    PictureRequest request = request_of(scene);
    request.integrator = integrator.name;
    request.settings = integrator.settings;
    request.spp = samples_of_form(4096);
    expect_same(measure_pictures(request), expected, relative);
  }
}

/// One side of a rectangle, and a ball.
constexpr const char* kPlate =
    "shapes { polygon { corners: [-0.5,-0.3,0, -0.5,0.3,0, 0.5,0.3,0, 0.5,-0.3,0] } area_light { radiance { "
    "constant: 4 } } ";
constexpr const char* kBall = "shapes { sphere { radius: 0.2 } area_light { radiance { constant: 3 } } ";

std::string placed(const char* what, const std::string& elements) {
  return absl::StrCat(what, " { elements: [", elements, "] } ");
}
// Places of the lamps within their object, and of the object: turned about z, mirrored and stretched.
constexpr const char* kInPlate = "1,0,0,0.3, 0,1,0,0, 0,0,1,0.2, 0,0,0,1";
constexpr const char* kFirst = "0.6,-0.8,0,-1, 0.8,0.6,0,-0.4, 0,0,1,2, 0,0,0,1";
constexpr const char* kSecond = "1,0,0,0.8, 0,1.5,0,0.6, 0,0,-1,2.2, 0,0,0,1";
// Their products.
constexpr const char* kFirstPlate = "0.6,-0.8,0,-0.82, 0.8,0.6,0,-0.16, 0,0,1,2.2, 0,0,0,1";
constexpr const char* kSecondPlate = "1,0,0,1.1, 0,1.5,0,0.6, 0,0,-1,2, 0,0,0,1";

TEST(PlacedLamp, ShinesAtEachOfItsPlaces) {
  const auto instance = [](const char* object, const std::string& at) {
    return absl::StrCat("instances { object: '", object, "' ", placed("world_from_instance", at), "} ");
  };
  const std::string objects =
      absl::StrCat("objects { name: 'lamps' ", kPlate, placed("world_from_object", kInPlate), "} ", kBall,
                   "} } objects { name: 'row' ", instance("lamps", kFirst), instance("lamps", kSecond),
                   "} instances { object: 'row' } ");
  // A sphere that a shape's own matrix mirrors is turned over, as in pbrt; one that an instance mirrors is
  // not.
  const std::string world = absl::StrCat(
      kPlate, placed("world_from_object", kFirstPlate), "} ", kBall, placed("world_from_object", kFirst),
      "} ", kPlate, placed("world_from_object", kSecondPlate), "} ", kBall, "reverse_orientation: true ",
      placed("world_from_object", kSecond), "} ");
  PictureRequest expected = request_of(world);
  expected.spp = samples_of_form(4096);
  expect_all(objects, measure_pictures(expected), 3e-3);
}

TEST(PlacedLamp, MovesWithItsInstanceAndItsLevel) {
  const Placing start{0, {0.7, 0.7, 0.7}, {-0.5, -0.3, 1.8}}, end{70, {0.9, 0.5, 0.9}, {0.4, 0.2, 2.2}};
  const std::string lift = placed("world_from_instance", "1,0,0,0, 0,1,0,0, 0,0,1,0.2, 0,0,0,1");
  const std::string plate = absl::StrCat("objects { name: 'lamp' ", kPlate, "} } ");
  expect_all(
      absl::StrCat(plate, "objects { name: 'arm' instances { object: 'lamp' ", lift,
                   "} } instances { object: 'arm' ", matrices("world_from_instance", start, end), "} "),
      mean_of_stills([&](double time) {
        PictureRequest request = request_of(absl::StrCat(
            plate, "objects { name: 'arm' instances { object: 'lamp' ", lift,
            "} } instances { object: 'arm' ", matrices("world_from_instance", start, end, time), "} "));
        request.settings = "path_sharing: PATH_SHARING_OFF";
        return request;
      }),
      3e-3);
}

}  // namespace
}  // namespace tessera::test::placed_lamp
