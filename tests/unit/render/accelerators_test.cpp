// One picture, whatever rays search.
#include <gtest/gtest.h>

#include <string>

#include "support/picture/render_image.h"
#include "support/picture/scene_file.h"
#include "wire/enum_words.h"

namespace tessera::test::accelerators {
namespace {

/// Spheres, disks and a cylinder, objects placed, turned and mirrored, one that moves, glass, a lamp.
constexpr const char* kScene = R"(
film { width: 48 height: 48 filter { kind: BOX } }
camera { perspective { fov_degrees: 45 } world_from_camera {
  elements: [1,0,0,0, 0,0.96,-0.28,2.5, 0,0.28,0.96,-6, 0,0,0,1] } }
materials { name: 'white' diffuse { reflectance { constant { constant: 0.7 } } } }
materials { name: 'glass' dielectric { eta { constant: 1.5 } } }
lights { infinite { radiance { constant: 0.3 } } }
shapes { name: 'floor' material: 'white' disk { radius: 20 }
  world_from_object { elements: [1,0,0,0, 0,0,1,0, 0,-1,0,0, 0,0,0,1] } }
shapes { name: 'ball' material: 'glass' sphere { radius: 0.8 }
  world_from_object { elements: [1,0,0,-1, 0,1,0,0.8, 0,0,1,0, 0,0,0,1] } }
shapes { name: 'mover' material: 'white' sphere { radius: 0.3 }
  world_from_object { elements: [1,0,0,0, 0,1,0,0.4, 0,0,1,-1.5, 0,0,0,1] }
  world_from_object_end { elements: [1,0,0,0.5, 0,1,0,0.6, 0,0,1,-1.5, 0,0,0,1] } }
objects { name: 'post' shapes { material: 'white' cylinder { radius: 0.2 z_min: 0 z_max: 1 } }
  shapes { material: 'white' sphere { radius: 0.3 } world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,1,1.2, 0,0,0,1] } } }
instances { object: 'post' world_from_instance { elements: [1,0,0,1, 0,0,1,0, 0,-1,0,0.5, 0,0,0,1] } }
instances { object: 'post' world_from_instance { elements: [-0.7,0.2,0,1.8, 0,0,1.1,0, 0.2,0.7,0,-0.5, 0,0,0,1] } }
)";

std::string pixels(v1::Accelerator accelerator, v1::Traversal traversal = v1::TRAVERSAL_PACKET) {
  SceneJob job;
  job.settings.set_spp(8);
  job.settings.set_accelerator(accelerator);
  job.settings.set_traversal(traversal);
  const auto file = load_scene_text(kScene, job, render::supported_isas().front());
  EXPECT_TRUE(file.ok()) << file.status();
  if (!file.ok()) return "";
  const client::Image image = render_image(*file);
  std::string bytes;
  for (const auto& channel : image.channels) {
    bytes.append(channel.name);
    bytes.append(reinterpret_cast<const char*>(channel.values.data()), 4 * channel.values.size());
  }
  return bytes;
}

TEST(Accelerators, AllGiveTheSameBits) {
  const std::string expected = pixels(v1::ACCELERATOR_BRUTE);
  ASSERT_GT(expected.size(), 3u * 4 * 48 * 48);
  for (int a = v1::ACCELERATOR_BRUTE + 1; a <= v1::Accelerator_MAX; ++a) {
    const auto accelerator = static_cast<v1::Accelerator>(a);
    EXPECT_TRUE(pixels(accelerator) == expected) << wire::word_of(accelerator);
  }
}

}  // namespace
}  // namespace tessera::test::accelerators
