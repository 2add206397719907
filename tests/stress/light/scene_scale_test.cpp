// One scene at many sizes, by every algorithm, with the same random numbers: sizes are powers of two, which
// floats multiply by without rounding, so that a picture differs only where some quantity is not one of the
// scene's own size, or leaves the range of floats.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "support/long_form.h"
#include "support/picture/phases.h"
#include "support/picture/render_image.h"
#include "wire/algorithm.h"
#include "wire/mesh_blob.h"

namespace tessera::test::scene_scale {
namespace {

/// All digits: StrCat writes six.
std::string exact(double x) { return absl::StrFormat("%.17g", x); }

/// A square of side 2 at z = 0, facing up.
std::string square() {
  wire::MeshData mesh;
  mesh.positions = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
  mesh.indices = {0, 1, 2, 0, 2, 3};
  return wire::encode_mesh(mesh);
}

/// A row-major matrix with x, y and z of these axes, all times `size`.
std::string matrix(double size, const double (&axes)[3][3], const double (&place)[3]) {
  std::string text = "{ elements: [";
  for (int row = 0; row < 3; ++row) {
    for (const auto& axis : axes) absl::StrAppend(&text, exact(size * axis[row]), ",");
    absl::StrAppend(&text, exact(size * place[row]), ",");
  }
  return text + "0,0,0,1] }";
}

enum class Lamp { kSquare, kPoint, kSoft };

/// Contents of the room.
struct Room {
  Lamp lamp = Lamp::kSquare;
  bool balls = false;  // balls of mirror, metal, glass and varnish
  bool fog = false;    // around the camera; then there is smoke in balls of glass and of nothing
};

/// A medium that takes half of the light within some two units of the room, where `density` is 1.
std::string medium(const char* name, double size, double density) {
  return absl::StrCat("media { name: '", name,
                      "' extinction { constant { rgb { r: 0.2 g: 0.3 b: 0.4 } } } scale: ",
                      exact(density / size), " albedo { constant { constant: 0.8 } } g: 0.3 } ");
}

/// Six balls in a row before the shelf, and media.
std::string balls_text(double size, bool fog) {
  constexpr double kUpright[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  struct Ball {
    const char* material;
    const char* inside = "fog";
  };
  constexpr const char* kRough = "roughness { u { constant: 0.2 } v { constant: 0.2 } } }";
  const std::string metal = absl::StrCat("conductor { reflectance { constant { constant: 0.8 } } ", kRough),
                    frosted = absl::StrCat("dielectric { eta { constant: 1.5 } ", kRough);
  std::string text = fog ? medium("fog", size, 1) + medium("smoke", size, 3) : "";
  double x = -1.75;
  for (const Ball& ball :
       {Ball{"conductor { reflectance { constant { constant: 0.9 } } }"}, Ball{metal.c_str()},
        Ball{"dielectric { eta { constant: 1.5 } }", "smoke"}, Ball{frosted.c_str()},
        Ball{"coated_diffuse { reflectance { constant { constant: 0.6 } } eta { constant: 1.5 } }"},
        Ball{"interface { }", "smoke"}}) {
    const std::string name = absl::StrCat("ball at ", x);
    absl::StrAppend(&text, "materials { name: '", name, "' ", ball.material,
                    " } shapes { sphere { radius: 0.3 } material: '", name, "' world_from_object ",
                    matrix(size, kUpright, {x, -0.8, 0.5}),
                    fog ? absl::StrCat(" exterior_medium: 'fog' interior_medium: '", ball.inside, "'") : "",
                    " } ");
    x += 0.7;
  }
  return text;
}

/// A room without ceiling: a floor, a back wall, a wall on the left, a shelf, and a lamp.
std::string room_text(double size, const Room& room) {
  constexpr double kFloor[3][3] = {{2, 0, 0}, {0, 2, 0}, {0, 0, 1}},
                   kShelf[3][3] = {{.5, 0, 0}, {0, .5, 0}, {0, 0, 1}},
                   kBack[3][3] = {{2, 0, 0}, {0, 0, 2}, {0, -1, 0}},
                   kLeft[3][3] = {{0, -2, 0}, {0, 0, 2}, {-1, 0, 0}},
                   kLamp[3][3] = {{.5, 0, 0}, {0, -.5, 0}, {0, 0, -1}};
  const auto shape = [&](const char* material, const auto& axes, const double(&place)[3], const char* more) {
    return absl::StrCat("shapes { mesh { blob { digest: 'square' } } material: '", material,
                        "' world_from_object ", matrix(size, axes, place), more, " } ");
  };
  return (room.balls ? balls_text(size, room.fog) : "") + shape("white", kFloor, {0, 0, 0}, "") +
         shape("white", kBack, {0, 2, 2}, "") + shape("red", kLeft, {-2, 0, 2}, "") +
         shape("white", kShelf, {0.5, 0.5, 0.75}, "") +
         (room.lamp == Lamp::kSquare
              ? shape("white", kLamp, {0, 0, 3}, " area_light { radiance { constant: 4 } }")
              : absl::StrCat("lights { point { position { z: ", exact(3 * size),
                             " } intensity { constant: ", exact(0.25 * size * size),
                             " } radius: ", room.lamp == Lamp::kSoft ? exact(0.5 * size) : "0", " } } ")) +
         "materials { name: 'white' diffuse { reflectance { constant { constant: 0.6 } } } } "
         "materials { name: 'red' diffuse { reflectance { constant { rgb { r: 0.6 g: 0.2 b: 0.1 } } } } } ";
}

/// All values of R, G and B; none where the algorithm refuses the scene.
std::vector<float> picture(const std::string& settings, double size, const Room& room) {
  // At (0, -6, 1.5), looking along y.
  constexpr double kAxes[3][3] = {{1, 0, 0}, {0, 0, 1}, {0, 1, 0}};
  const auto file = load_scene_text(
      absl::StrCat(room_text(size, room), "camera { perspective { fov_degrees: 40 } world_from_camera ",
                   matrix(1, kAxes, {0, -6 * size, 1.5 * size}), room.fog ? " medium: 'fog'" : "",
                   " } film { width: 16 height: 16 } settings { spp: 4 max_depth: 4 ", settings, " }"),
      {}, render::supported_isas().front(), {{"square", square()}});
  if (!file.ok()) {
    EXPECT_TRUE(absl::IsInvalidArgument(file.status())) << file.status();
    return {};
  }
  const MadePhases made = make_phases(*file);
  const client::Image image = render_image(*file, 0, made.prepared.get());
  std::vector<float> values;
  for (const char* const channel : {"R", "G", "B"}) {
    const client::Channel* const plane = image.find(channel);
    if (plane != nullptr) values.insert(values.end(), plane->values.begin(), plane->values.end());
  }
  return values;
}

double mean_of(const std::vector<float>& values) {
  double sum = 0;
  for (const float value : values) sum += double{value};
  return sum / static_cast<double>(values.size());
}

void expect_equal_means(const Room& room) {
  const std::vector<int> exponents = long_form()  ? std::vector{-30, -27, -20, -10, 10, 20, 27, 30}
                                     : room.balls ? std::vector{-30, 30}
                                                  : std::vector{-30, 27, 30};
  for (const wire::AlgorithmTraits& algorithm : wire::algorithms()) {
    SCOPED_TRACE(algorithm.name);
    const std::string settings = absl::StrCat("integrator: '", algorithm.name, "' ");
    const std::vector<float> expected = picture(settings, 1, room);
    if (expected.empty()) continue;
    const double mean = mean_of(expected);
    // Whoever sees lamps with a surface alone sees none of these.
    if (room.lamp != Lamp::kSquare && mean == 0) continue;
    EXPECT_GT(mean, 0);
    for (const int exponent : exponents) {
      const std::vector<float> found = picture(settings, std::ldexp(1.0, exponent), room);
      ASSERT_EQ(found.size(), expected.size()) << "2^" << exponent;
      // Scenes of up to 4096 units have their point lights looked at from one unit away
      // (positional_light.h): from 3 * 2^10, places are rounded to 2^-13, and squares are off by twice that.
      const bool rounded = room.lamp != Lamp::kSquare && exponent == 10;
      EXPECT_NEAR(mean_of(found) / mean, 1, rounded ? 0x1p-12 : 1e-6) << "2^" << exponent;
    }
  }
}

TEST(SceneScale, PicturesAreTheSameFromABillionthToABillion) { expect_equal_means({}); }

TEST(SceneScale, SoAreThoseOfPointLights) { expect_equal_means({.lamp = Lamp::kPoint}); }

TEST(SceneScale, SoAreThoseOfSoftLights) { expect_equal_means({.lamp = Lamp::kSoft}); }

TEST(SceneScale, SoAreThoseOfMetalAndGlass) {
  for (const Lamp lamp : {Lamp::kSquare, Lamp::kPoint}) expect_equal_means({.lamp = lamp, .balls = true});
}

TEST(SceneScale, SoAreThoseOfFogAndSmoke) {
  for (const Lamp lamp : {Lamp::kSquare, Lamp::kPoint})
    expect_equal_means({.lamp = lamp, .balls = true, .fog = true});
}

}  // namespace
}  // namespace tessera::test::scene_scale
