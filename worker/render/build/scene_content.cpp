#include "render/build/scene_content.h"

#include <algorithm>
#include <bit>
#include <future>

#include "absl/strings/str_cat.h"
#include "render/accel/embree/embree_kernel.h"
#include "render/build/scene_builder.h"
#include "wire/message_digest.h"

namespace tessera::render {

std::string content_key(const v1::Scene& scene, const v1::JobSpec& job, const std::string& isa) {
  v1::Scene relevant = scene;
  relevant.clear_name();
  relevant.clear_film();
  relevant.clear_settings();  // wishes: what holds is in the job
  v1::Camera& camera = *relevant.mutable_camera();
  camera.clear_kind();
  camera.clear_screen_window();
  camera.clear_near_clip();
  camera.clear_far_clip();
  const auto world_from_camera = Transform::from_proto(camera.world_from_camera());
  std::string key = absl::StrCat(isa, " ");
  if (camera.world_from_camera_end().elements().empty() && world_from_camera.ok()) {
    const Point origin = render_origin(scene, *world_from_camera);
    absl::StrAppend(&key, absl::Hex(std::bit_cast<std::uint64_t>(origin.x)), " ",
                    absl::Hex(std::bit_cast<std::uint64_t>(origin.y)), " ",
                    absl::Hex(std::bit_cast<std::uint64_t>(origin.z)), " ");
    camera.clear_world_from_camera();
  }
  return absl::StrCat(key, wire::digest_of({&job.content().algorithms(), &relevant}));
}

absl::StatusOr<std::shared_ptr<const SceneContent>> build_content(
    const v1::Scene& scene, const v1::JobSpec& job, const BlobSource& blobs, const LoadOptions& options,
    const EmbreeKernel& embree, LightSources light_sources) {
  auto content = std::make_shared<SceneContent>();
  SceneTables& tables = content->tables;
  content->arrays.lights.sources = light_sources;
  SceneBuilder builder(scene, job, blobs, options.threads, content->arrays, tables, content->warnings);
  if (auto s = builder.build_tables(); !s.ok()) return s;
  if (options.geometry_read) options.geometry_read();
  // Images have nothing to do with the BVH. A worker of one thread uses one.
  std::future<absl::Status> images =
      std::async(options.threads > 1 ? std::launch::async : std::launch::deferred,
                 [&] { return builder.decode_images(); });
  auto built = Accelerator::build(content->arrays.shapes, content->arrays.textures, embree.callbacks,
                                  {options.threads, options.isa, builder.wants_robust_intersection()});
  if (auto s = images.get(); !s.ok()) return s;
  if (!built.ok()) return built.status();
  const Accelerator& accelerator = *(content->accelerator = *std::move(built));
  content->rays =
      embree.make_query(accelerator.scene(), static_cast<std::int32_t>(content->arrays.shapes.shapes.size()),
                        builder.wants_single_rays());
  for (const v1::Material& material : scene.materials()) content->material_names.push_back(material.name());
  content->material_names.resize(content->arrays.materials.materials.size(), "(default)");
  std::copy_n(accelerator.bounding_centre(), 3, content->arrays.lights.scene_centre);
  if (auto s = builder.check_instances(accelerator.bounding_centre(), accelerator.bounding_radius()); !s.ok())
    return s;
  if (auto s = builder.build_light_selection(accelerator.bounding_radius()); !s.ok()) return s;
  return content;
}

absl::Status SceneBuilder::build_tables() {
  for (const auto step :
       {&SceneBuilder::build_settings, &SceneBuilder::build_camera, &SceneBuilder::build_filter,
        &SceneBuilder::build_textures, &SceneBuilder::build_media, &SceneBuilder::build_materials,
        &SceneBuilder::build_shapes, &SceneBuilder::build_lights}) {
    if (auto s = (this->*step)(); !s.ok()) return s;
  }
  decide_volumetric();
  build_shading_groups();
  return absl::OkStatus();
}

absl::Status SceneBuilder::rebuild_view() {
  const std::int32_t medium = tables_.camera.medium;
  tables_.camera = {};
  tables_.camera.medium = medium;
  tables_.aovs = {};
  for (const auto step :
       {&SceneBuilder::build_settings, &SceneBuilder::build_camera, &SceneBuilder::build_filter}) {
    if (auto s = (this->*step)(); !s.ok()) return s;
  }
  return absl::OkStatus();
}

}  // namespace tessera::render
