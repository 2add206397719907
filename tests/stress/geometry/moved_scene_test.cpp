// The same scene in another unit of length, or far from the origin, gives the same picture.
#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <string>

#include "render/scene/load_scene.h"
#include "stress/geometry/closed_mesh.h"
#include "stress/geometry/moved_scene.h"
#include "support/needs.h"
#include "support/picture/render_image.h"
#include "support/picture/scene_file.h"
#include "wire/mesh_blob.h"

namespace tessera::test {
namespace {

test::SceneJob small_job(std::uint32_t spp) {
  test::SceneJob job;
  job.width = 64, job.height = 64;
  job.settings.set_spp(spp);
  job.settings.set_seed(3);
  return job;
}

/// Spheres, cut and whole, a disk, a cylinder, instances near and far from the origin of their object,
/// something that moves, textures in space and on surfaces, every kind of light that stands somewhere, and a
/// lens.
constexpr const char* kMixed = R"(
film { width: 64 height: 64 filter { kind: BOX } }
settings { max_depth: 6 }
camera { perspective { fov_degrees: 40 lens_radius: 0.03 focal_distance: 6 } near_clip: 0.5 far_clip: 40
  world_from_camera { elements: [1,0,0,0.5, 0,0.96,-0.28,2.5, 0,0.28,0.96,-6, 0,0,0,1] } }
textures { name: 'checks' checkerboard { even { constant { constant: 0.7 } }
  odd { constant { rgb { r: 0.2 g: 0.3 b: 0.1 } } } mapping { scale_u: 8 scale_v: 8 } } }
textures { name: 'cloud' noise { kind: FBM
  texture_from_world { elements: [2,0,0,0.3, 0,2,0,0.1, 0,0,2,0.2, 0,0,0,1] } } }
materials { name: 'floor' diffuse { reflectance { texture: 'checks' } } }
materials { name: 'stone' diffuse { reflectance { texture: 'cloud' } } }
materials { name: 'glass' dielectric { eta { constant: 1.5 } } }
materials { name: 'metal' conductor { reflectance { constant { constant: 0.8 } }
  roughness { u { constant: 0.2 } v { constant: 0.2 } } } }
shapes { material: 'floor' mesh { blob { digest: 'floor' } } }
shapes { material: 'glass' sphere { radius: 0.8 }
  world_from_object { elements: [1,0,0,-1.2, 0,1,0,0.8, 0,0,1,0, 0,0,0,1] } }
shapes { material: 'stone' sphere { radius: 0.7 z_min: -0.5 z_max: 0.4 phi_max_degrees: 250 }
  world_from_object { elements: [0.6,0,0.8,1.6, 0,1,0,0.7, -0.8,0,0.6,0.3, 0,0,0,1] } }
shapes { material: 'metal' cylinder { radius: 0.3 z_min: 0 z_max: 1.5 }
  world_from_object { elements: [1,0,0,0.2, 0,0,1,0, 0,-1,0,1.6, 0,0,0,1] } }
shapes { material: 'stone' sphere { radius: 0.25 }
  world_from_object { elements: [1,0,0,-2.4, 0,1,0,1.6, 0,0,1,1, 0,0,0,1] }
  world_from_object_end { elements: [1,0,0,-2.2, 0,1,0,1.9, 0,0,1,1, 0,0,0,1] } }
shapes { disk { radius: 0.6 } area_light { radiance { constant: 9 } }
  world_from_object { elements: [1,0,0,0, 0,0,-1,4, 0,1,0,0, 0,0,0,1] } reverse_orientation: true }
objects { name: 'near' shapes { material: 'metal' mesh { blob { digest: 'ball' } } } }
objects { name: 'far' shapes { material: 'stone' mesh { blob { digest: 'ball' } }
  world_from_object { elements: [1,0,0,1e7, 0,1,0,-2e7, 0,0,1,3e7, 0,0,0,1] } } }
instances { object: 'near' world_from_instance { elements: [0.4,0,0,0.6, 0,0.4,0,0.5, 0,0,0.4,-1, 0,0,0,1] } }
instances { object: 'near' world_from_instance {
  elements: [0.2,0,0,-0.3, 0,0.2,0,0.3, 0,0,0.2,-1.5, 0,0,0,1] } }
instances { object: 'far' world_from_instance {
  elements: [0.3,0,0,-2999997.6, 0,0.3,0,6000000.4, 0,0,0.3,-9000001, 0,0,0,1] } }
lights { point { position { x: -3 y: 3 z: -3 } intensity { constant: 6 } } }
lights { spot { position { x: 3 y: 4 z: -2 } target { x: 0.5 y: 0.4 z: 0 } intensity { constant: 30 }
  cone_angle_degrees: 20 cone_delta_degrees: 5 } }
lights { infinite { radiance { rgb { r: 0.2 g: 0.25 b: 0.4 } } } }
)";

TestBlobs mixed_blobs() {
  const render::ClosedMesh ball = render::displaced_sphere(3);
  wire::MeshData mesh;
  for (const auto& p : ball.vertices) {
    for (const double x : p) mesh.positions.push_back(static_cast<float>(x));
  }
  for (const auto& t : ball.triangles) mesh.indices.insert(mesh.indices.end(), t.begin(), t.end());
  wire::MeshData floor;
  floor.positions = {-8, 0, -8, 8, 0, -8, 8, 0, 8, -8, 0, 8};
  floor.uvs = {0, 0, 1, 0, 1, 1, 0, 1};
  floor.indices = {0, 2, 1, 0, 3, 2};
  return {{"ball", wire::encode_mesh(mesh)}, {"floor", wire::encode_mesh(floor)}};
}

client::Image mixed(const Move& move, const std::function<void(v1::Scene&)>& edit = {}) {
  v1::Scene scene;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(kMixed, &scene));
  if (edit) edit(scene);
  move_scene(move, scene);
  std::string text;
  google::protobuf::TextFormat::PrintToString(scene, &text);
  const auto file = load_scene_text(text, small_job(256), render::supported_isas().front(), mixed_blobs());
  EXPECT_TRUE(file.ok()) << file.status();
  return file.ok() ? render_image(*file) : client::Image{};
}

client::Image from_file(const std::string& path, const Move& move) {
  const auto file = load_scene_file(path, small_job(256), render::supported_isas().front(), 2,
                                    [&](v1::Scene& scene) { move_scene(move, scene); });
  EXPECT_TRUE(file.ok()) << file.status();
  return file.ok() ? render_image(*file) : client::Image{};
}

/// Mean of squared differences over squares; a hundredth of the mean keeps black pixels out.
double relmse(const client::Image& test, const client::Image& base) {
  double sum = 0, count = 0;
  for (const char* channel : {"R", "G", "B"}) {
    const std::vector<float>&a = test.find(channel)->values, &b = base.find(channel)->values;
    double mean = 0;
    for (const float x : b) mean += x / static_cast<double>(b.size());
    for (std::size_t i = 0; i < b.size(); ++i, ++count) {
      const double difference = double{a[i]} - b[i];
      sum += difference * difference / (double{b[i]} * b[i] + 1e-4 * mean * mean);
    }
  }
  return sum / count;
}

constexpr Move kMoves[] = {{1e-6}, {1e6}, {1, {1e7, -2e7, 1.5e7}}, {1e-3, {1e4, 0, 1e4}}};

void expect_same(const std::function<client::Image(const Move&)>& render) {
  const client::Image base = render({});
  ASSERT_FALSE(base.channels.empty());
  for (const Move& move : kMoves) {
    const client::Image image = render(move);
    ASSERT_FALSE(image.channels.empty());
    EXPECT_LT(relmse(image, base), 1e-6) << "scaled by " << move.scale << ", moved by " << move.shift[0];
  }
}

TEST(MovedScene, MixedLooksTheSame) {
  expect_same([](const Move& move) { return mixed(move); });
}

TEST(MovedScene, ObjectsMayBeModelledFarFromTheirOrigin) {
  const client::Image image = mixed({}),
                      base = mixed({}, [](v1::Scene&scene) {
                        // 'far' about its origin, and its instance where that puts it: 0.3 (1e7, -2e7, 3e7)
                        // goes over from one translation to the other.
                        scene.mutable_objects(1)->mutable_shapes(0)->clear_world_from_object();
                        auto& place =
                            *scene.mutable_instances(2)->mutable_world_from_instance()->mutable_elements();
                        place[3] = 2.4, place[7] = 0.4, place[11] = -1;
                      });
  ASSERT_FALSE(image.channels.empty() || base.channels.empty());
  EXPECT_LT(relmse(image, base), 1e-6);
}

/// Half-space, box, cones, cylinder with caps, torus, polygon, polyhedron, ellipsoid.
TEST(MovedScene, SolidsFarAwayLookTheSame) {
  const std::string path = "scenes/solids/scene.textproto";
  const client::Image base = from_file(path, {}), moved = from_file(path, {1, {1e7, -2e7, 1.5e7}});
  ASSERT_FALSE(base.channels.empty() || moved.channels.empty());
  EXPECT_LT(relmse(moved, base), 1e-6);
}

TEST(MovedScene, CornellBoxLooksTheSame) {
  const std::string path = "../shared/scenes/pbrt/cornell-box/scene.pbrt";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << needs("../shared/scenes");
  expect_same([&](const Move& move) { return from_file(path, move); });
}

}  // namespace
}  // namespace tessera::test
