// Radiosity of whole scenes: its mesh, and blobs that are damaged on their way.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "absl/strings/str_cat.h"
#include "google/protobuf/text_format.h"
#include "render/scene/diffuse/radiosity_mesh.h"
#include "support/picture/phases.h"
#include "wire/mesh_blob.h"

namespace tessera::test::radiosity_scene {
namespace {

/// A square of side 2 in the plane z = 0, facing +z.
std::string square() {
  wire::MeshData mesh;
  mesh.positions = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
  mesh.indices = {0, 1, 2, 0, 2, 3};
  return wire::encode_mesh(mesh);
}

/// A floor under a lamp, and a square beside the lamp as an instance, which `mirror` (1 or -1) may mirror.
std::string scene(int mirror) {
  return absl::StrCat(
      "render_origin {} camera { perspective { fov_degrees: 40 } } film { width: 8 height: 8 } "
      "materials { name: 'paint' diffuse { reflectance { constant { constant: 0.5 } } } } "
      "lights { point { position { x: 0.5 z: 1.5 } intensity { constant: 3 } } } "
      "shapes { mesh { blob { digest: 'square' } } material: 'paint' } "
      "objects { name: 'wall' shapes { mesh { blob { digest: 'square' } } material: 'paint' } } "
      "instances { object: 'wall' world_from_instance { elements: [0,0,1,-1, 0,",
      mirror, ",0,0, -1,0,0,1, 0,0,0,1] } }");
}

struct Loaded {
  LoadedFile file;
  MadePhases phases;
};

/// With phases made. `limit`: bytes of memory, 0 for the usual.
Loaded load_made(const std::string& text, std::uint64_t limit = 0) {
  SceneJob job;
  job.settings.set_integrator("radiosity");
  job.settings.mutable_radiosity()->set_error_bound(0.2);
  if (limit > 0) job.settings.mutable_radiosity()->set_memory_limit(limit);
  auto file = load_scene_text(text, job, render::supported_isas().front(), {{"square", square()}});
  EXPECT_TRUE(file.ok()) << file.status();
  if (!file.ok()) return {};
  Loaded loaded{*std::move(file), {}};
  loaded.phases = make_phases(loaded.file);
  return loaded;
}

TEST(RadiosityMesh, IsWoundToItsLightOnMirroredInstancesToo) {
  for (const int mirror : {1, -1}) {
    const std::string text = scene(mirror);
    const Loaded loaded = load_made(text);
    ASSERT_EQ(loaded.phases.blobs.size(), 3u);
    v1::Scene message;
    ASSERT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &message));
    const auto mesh = render::read_radiosity_mesh(message, loaded.phases.blobs.back());
    ASSERT_TRUE(mesh.ok()) << mesh.status();
    // Twice the area, with the winding's sign, along z of what lies on the floor, and along x of the wall.
    double floor = 0, wall = 0;
    for (const std::array<std::uint32_t, 3>& triangle : mesh->triangles) {
      const auto& a = mesh->positions[triangle[0]];
      const auto& b = mesh->positions[triangle[1]];
      const auto& c = mesh->positions[triangle[2]];
      const auto across = [&](std::size_t i, std::size_t j) {
        return double{b[i] - a[i]} * double{c[j] - a[j]} - double{b[j] - a[j]} * double{c[i] - a[i]};
      };
      floor += across(0, 1);
      wall += across(1, 2);
    }
    EXPECT_NEAR(floor, 8, 1e-4) << mirror;
    EXPECT_NEAR(wall, 8, 1e-4) << mirror;
  }
}

/// The blob with another value at a byte's place.
template <class T>
std::string with(std::string blob, std::size_t place, T value) {
  std::memcpy(blob.data() + place, &value, sizeof(value));
  return blob;
}

TEST(RadiosityScene, DamagedLinksAreNoReasonToWait) {
  const Loaded loaded = load_made(scene(1));
  ASSERT_EQ(loaded.phases.blobs.size(), 3u);
  const render::RenderScene& rendered = *loaded.file.scene;
  const std::string &estimate = loaded.phases.blobs[0], &links = loaded.phases.blobs[1];
  std::uint64_t count = 0;
  std::memcpy(&count, links.data(), sizeof(count));
  ASSERT_GT(count, 0u);
  const auto prepared = [&](const std::string& first, const std::string& second) {
    return rendered.prepare(std::vector<std::string_view>{first, second}).status();
  };
  EXPECT_TRUE(prepared(estimate, links).ok());
  // After the number of links, each has its receiver's name, its source's, and its factor.
  const std::string damaged[] = {with(links, 8, std::uint64_t{1} << 40), with(links, 16, ~std::uint64_t{0}),
                                 with(links, 24, -0.5), with(links, 24, double{NAN})};
  for (const std::string& blob : damaged) {
    EXPECT_EQ(prepared(estimate, blob).code(), absl::StatusCode::kInvalidArgument) << &blob - damaged;
  }
  EXPECT_FALSE(rendered.prepare(std::vector<std::string_view>{with(estimate, 24, 7.0)}).ok());
}

TEST(RadiosityScene, MorePatchesThanThereIsRoomForAreNoStop) {
  const Loaded loaded = load_made(scene(1), 24'000);
  ASSERT_EQ(loaded.phases.blobs.size(), 3u);
  const render::RenderScene& rendered = *loaded.file.scene;
  // Three links between patches 14 splits deep: 8 sides, and 56 parts for each.
  struct Link {
    std::uint64_t receiver, source;
    double factor;
  };
  std::string blob;
  const auto put = [&](const auto& value) {
    blob.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  put(std::uint64_t{3});
  for (std::uint64_t side = 0; side < 3; ++side) {
    const auto patch = [](std::uint64_t of) { return of << 32 | std::uint64_t{14} << 28; };
    put(Link{patch(side), patch(side + 4), 0.1});
  }
  put(std::uint64_t{0});
  put(std::uint64_t{1}), put(std::uint64_t{0});
  const auto prepared =
      rendered.prepare(std::vector<std::string_view>{loaded.phases.blobs[0], std::string_view(blob)});
  ASSERT_TRUE(prepared.ok()) << prepared.status();
  render::RenderStats stats;
  const auto solution = rendered.make_part({2, 0, 1, prepared->get()}, {}, {}, stats);
  EXPECT_EQ(solution.status().code(), absl::StatusCode::kInvalidArgument) << solution.status();
}

TEST(RadiosityScene, StopsBetweenSweeps) {
  const Loaded loaded = load_made(scene(1));
  ASSERT_EQ(loaded.phases.blobs.size(), 3u);
  const render::RenderScene& rendered = *loaded.file.scene;
  std::stop_source stop;
  stop.request_stop();
  for (std::size_t phase = 1; phase < 3; ++phase) {
    const std::vector<std::string_view> blobs(
        loaded.phases.blobs.begin(), loaded.phases.blobs.begin() + static_cast<std::ptrdiff_t>(phase));
    const auto prepared = rendered.prepare(blobs);
    ASSERT_TRUE(prepared.ok()) << prepared.status();
    render::RenderStats stats;
    const render::PartRequest part{static_cast<std::uint32_t>(phase), 0, 1, prepared->get()};
    EXPECT_TRUE(absl::IsCancelled(rendered.make_part(part, {}, stop.get_token(), stats).status())) << phase;
    EXPECT_TRUE(rendered.make_part(part, {}, {}, stats).ok()) << phase << ": goes on";
  }
}

}  // namespace
}  // namespace tessera::test::radiosity_scene
