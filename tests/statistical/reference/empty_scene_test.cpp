// Scenes that lack whole kinds of things, by every algorithm and every ISA: their tables are empty, and
// nothing may be read from them.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "support/picture/phases.h"
#include "support/picture/render_image.h"
#include "wire/algorithm.h"

namespace tessera::test::empty_scene {  // apart from tests that are compiled with these
namespace {

struct Part {
  const char *name, *text;
};

constexpr Part kCameras[] = {{"a camera in vacuum", ""},
                             {"a camera in fog",
                              "media { name: 'fog' extinction { constant { constant: 0.5 } } albedo { "
                              "constant { constant: 0.8 } } }"}};
constexpr Part kShapes[] = {{"no shapes", ""},
                            {"a sphere", "shapes { sphere { radius: 0.1 } }"},
                            {"a sphere far away",
                             "shapes { sphere { radius: 0.1 } world_from_object { elements: [1, 0, 0, 0, "
                             "0, 1, 0, 0, 0, 0, 1, -50, 0, 0, 0, 1] } }"}};
constexpr Part kLights[] = {
    {"no lights", ""},
    {"a point light", "lights { point { position { z: 2 } intensity { constant: 1 } } }"},
    {"a distant light", "lights { distant { direction { y: -1 } irradiance { constant: 1 } } }"},
    {"a sky", "lights { infinite { radiance { constant: 1 } } }"}};

/// Renders the scene, or sees that it is refused. Without lights it is black, and finite with them.
bool renders(const std::string& scene, const wire::AlgorithmTraits& algorithm, const std::string& isa,
             bool is_lit) {
  const auto file = load_scene_text(
      absl::StrCat(scene, " settings { integrator: '", algorithm.name, "' spp: 2 }"), {}, isa);
  if (!file.ok()) {
    EXPECT_TRUE(absl::IsInvalidArgument(file.status())) << file.status();
    return false;
  }
  const MadePhases made = make_phases(*file);
  const client::Image image = render_image(*file, 0, made.prepared.get());
  const client::Channel* const green = image.find("G");
  EXPECT_NE(green, nullptr);
  if (green == nullptr) return false;
  for (const float value : green->values) {
    EXPECT_TRUE(is_lit ? std::isfinite(value) : value == 0) << value;
  }
  return true;
}

TEST(EmptyScene, IsBlackOrRefused) {
  for (const std::string& isa : render::supported_isas()) {
    for (const wire::AlgorithmTraits& algorithm : wire::algorithms()) {
      int rendered = 0;
      for (const Part& camera : kCameras) {
        for (const Part& shapes : kShapes) {
          for (const Part& lights : kLights) {
            SCOPED_TRACE(absl::StrCat(isa, ", ", algorithm.name, ": ", camera.name, ", ", shapes.name, ", ",
                                      lights.name));
            const bool in_fog = *camera.text != '\0', is_lit = *lights.text != '\0';
            const std::string scene =
                absl::StrCat("camera { perspective { fov_degrees: 40 } ", in_fog ? "medium: 'fog' " : "",
                             "} film { width: 24 height: 16 } ", camera.text, shapes.text, lights.text);
            rendered += renders(scene, algorithm, isa, is_lit) ? 1 : 0;
          }
        }
      }
      // Radiosity knows diffuse triangles alone.
      EXPECT_GE(rendered, algorithm.diffuse_only ? 0 : 1) << algorithm.name;
    }
  }
}

}  // namespace
}  // namespace tessera::test::empty_scene
