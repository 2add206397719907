// A sphere given by a function looks like a sphere: of glass, round a medium, textured, moving, in instances,
// mirrored, far away and in another unit of length.
#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "absl/strings/str_replace.h"
#include "render/scene/load_scene.h"
#include "stress/geometry/moved_scene.h"
#include "support/picture/render_image.h"
#include "support/picture/scene_file.h"

namespace tessera::test::implicit_picture {
namespace {

constexpr const char* kScene = R"(
film { width: 64 height: 48 filter { kind: BOX } }
settings { max_depth: 8 integrator: 'volpath' }
camera { perspective { fov_degrees: 40 }
  world_from_camera { elements: [1,0,0,0, 0,0.95,-0.3,1.9, 0,0.3,0.95,-6, 0,0,0,1] } }
textures { name: 'checks' checkerboard { even { constant { constant: 0.7 } }
  odd { constant { rgb { r: 0.2 g: 0.3 b: 0.1 } } } mapping { scale_u: 8 scale_v: 8 } } }
materials { name: 'checked' diffuse { reflectance { texture: 'checks' } } }
materials { name: 'glass' dielectric { eta { constant: 1.5 } } }
materials { name: 'air' interface {} }
media { name: 'fog' extinction { constant { constant: 1.8 } } albedo { constant { constant: 0.8 } } }
shapes { disk { radius: 20 } world_from_object { elements: [1,0,0,0, 0,0,1,-1.2, 0,-1,0,0, 0,0,0,1] } }
shapes { SHAPE material: 'glass'
  world_from_object { elements: [0.8,0,0,-2.2, 0,0.8,0,0, 0,0,0.8,0, 0,0,0,1] } }
shapes { SHAPE material: 'air' interior_medium: 'fog'
  world_from_object { elements: [0.8,0,0,0, 0,0.8,0,0, 0,0,0.8,0, 0,0,0,1] } }
shapes { SHAPE material: 'checked' world_from_object { elements: [0.5,0,0,2, 0,0.8,0,0, 0,0,-0.6,0, 0,0,0,1] }
  world_from_object_end { elements: [0.5,0,0,2.3, 0,0.8,0,0.3, 0,0,-0.6,0, 0,0,0,1] } }
objects { name: 'small' shapes { SHAPE material: 'checked'
  world_from_object { elements: [0.3,0,0,0, 0,0.3,0,0, 0,0,0.3,0, 0,0,0,1] } } }
instances { object: 'small' world_from_instance {
  elements: [1,0.3,0,-1.1, 0,1,0,-0.8, 0,0,1,-1.3, 0,0,0,1] } }
instances { object: 'small' world_from_instance {
  elements: [-1,0.3,0,1.1, 0,1,0,-0.8, 0,0,1,-1.3, 0,0,0,1] } }
shapes { disk { radius: 1 } area_light { radiance { constant: 20 } }
  world_from_object { elements: [1,0,0,-3, 0,0,-1,6, 0,1,0,-3, 0,0,0,1] } }
lights { infinite { radiance { constant: 0.5 } } }
)";

client::Image render_with(const std::string& shape, const Move& move) {
  v1::Scene scene;
  EXPECT_TRUE(
      google::protobuf::TextFormat::ParseFromString(absl::StrReplaceAll(kScene, {{"SHAPE", shape}}), &scene));
  move_scene(move, scene);
  scene.mutable_media(0)->set_scale(static_cast<float>(1 / move.scale));
  std::string text;
  google::protobuf::TextFormat::PrintToString(scene, &text);
  SceneJob job;
  job.width = 64, job.height = 48;
  job.settings.set_spp(64);
  job.settings.set_seed(5);
  const auto file = load_scene_text(text, job, render::supported_isas().front(), {});
  EXPECT_TRUE(file.ok()) << file.status();
  return file.ok() ? render_image(*file) : client::Image{};
}

/// The share of values that differ by more than a ten-thousandth: of paths that rounding led elsewhere.
double different(const client::Image& test, const client::Image& base) {
  double count = 0, all = 0;
  for (const char* channel : {"R", "G", "B"}) {
    const std::vector<float>&a = test.find(channel)->values, &b = base.find(channel)->values;
    for (std::size_t i = 0; i < b.size(); ++i, ++all) count += !(std::abs(a[i] - b[i]) <= 1e-4f * b[i]);
  }
  return count / all;
}

TEST(ImplicitPictures, AreThoseOfASphere) {
  const char* const spheres[] = {
      "implicit { expression: 'x^2 + y^2 + z^2 = 1' ball { radius: 1.2 } roots: STURM }",
      "implicit { expression: 'x^2 + y^2 + z^2 = 1' "
      "box { low { x: -1.1 y: -1.1 z: -1.1 } high { x: 1.1 y: 1.1 z: 1.1 } } roots: INTERVAL }",
      "implicit { expression: 'x^2 + y^2 + z^2 = 1' ball { radius: 1.2 } roots: NEWTON }",
      "implicit { expression: 'sqrt(x^2 + y^2 + z^2) - 1' ball { radius: 1.2 } }",
      "implicit { expression: 'sqrt(x^2 + y^2 + z^2) - 1' ball { radius: 1.2 } lipschitz: 1.0001 }"};
  for (const Move& move : {Move{}, Move{1e-3, {1e4, 0, 1e4}}, Move{1e6}}) {
    const client::Image base = render_with("sphere { radius: 1 }", move);
    ASSERT_FALSE(base.channels.empty());
    for (const char* shape : spheres) {
      const client::Image image = render_with(shape, move);
      ASSERT_FALSE(image.channels.empty());
      // Points are off by roundings, which send one path of some ten thousand another way: 64 a pixel.
      EXPECT_LT(different(image, base), 0.02) << shape << ", scaled by " << move.scale;
    }
  }
}

}  // namespace
}  // namespace tessera::test::implicit_picture
