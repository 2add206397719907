#include "render/build/load_scene.h"

#include <algorithm>
#include <bit>
#include <future>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/accel/accelerator.h"
#include "render/build/scene_builder.h"
#include "render/film/adaptive_tile.h"
#include "render/film/tile_accumulator.h"
#include "render/integrator/kernel.h"
#include "wire/cpu_time.h"
#include "wire/digest.h"
#include "wire/scene_numbers.h"

namespace tessera::render {

namespace {

double thread_cpu_seconds() { return wire::in_seconds(wire::thread_cpu_time()); }

/// All of a scene that does not depend on how it is looked at. `tables` has the view of the job that it was built for.
struct SceneContent {
  SceneArrays arrays;
  SceneTables tables{arrays};
  std::vector<std::string> warnings, material_names;
  std::unique_ptr<Accelerator> accelerator;  // reads the arrays: goes first
};

/// Of jobs with the same key all is the same but what SceneBuilder::rebuild_view() sets. Positions are relative to the
/// camera's origin, so that stays; settings that are not named here are taken to matter.
std::string content_key(const v1::Scene& scene, const v1::JobSpec& job, const std::string& isa) {
  v1::Scene relevant = scene;
  relevant.clear_name();
  relevant.clear_film();
  v1::Camera& camera = *relevant.mutable_camera();
  camera.clear_kind();
  camera.clear_screen_window();
  camera.clear_near_clip();
  camera.clear_far_clip();
  const auto world_from_camera = Transform::from_proto(camera.world_from_camera());
  std::string key = absl::StrCat(isa, " ");
  if (camera.world_from_camera_end().elements().empty() && world_from_camera.ok()) {
    const Point origin = world_from_camera->apply({0, 0, 0});
    absl::StrAppend(&key, absl::Hex(std::bit_cast<std::uint64_t>(origin.x)), " ",
                    absl::Hex(std::bit_cast<std::uint64_t>(origin.y)), " ",
                    absl::Hex(std::bit_cast<std::uint64_t>(origin.z)), " ");
    camera.clear_world_from_camera();
  }
  v1::RenderSettings settings = job.settings();
  settings.clear_sampler();
  settings.clear_spp();
  settings.clear_noise();
  settings.clear_max_depth();
  settings.clear_seed();
  return absl::StrCat(key, wire::sha256_hex(settings.SerializeAsString()),
                      wire::sha256_hex(relevant.SerializeAsString()));
}

class LoadedScene final : public RenderScene {
 public:
  static absl::StatusOr<std::unique_ptr<RenderScene>> load(const v1::Scene& scene, const v1::JobSpec& job,
                                                           const BlobSource& blobs, const LoadOptions& options) {
    const Kernel* const kernel = find_kernel(options.isa);
    if (!kernel) {
      return absl::FailedPreconditionError(
          absl::StrCat("this build or processor has no kernels for ISA '", options.isa, "'"));
    }
    auto channels = wire::channels_for_aovs({job.aovs().begin(), job.aovs().end()});
    if (!channels.ok()) return channels.status();
    if (job.width() == 0 || job.height() == 0) return absl::InvalidArgumentError("the film has no pixels");
    if (auto s = wire::check_scene_numbers(scene); !s.ok()) return s;

    const std::string key = options.contents ? content_key(scene, job, options.isa) : "";
    if (options.contents) {
      if (auto known = std::static_pointer_cast<const SceneContent>(options.contents->find(key))) {
        auto self = std::unique_ptr<LoadedScene>(
            new LoadedScene(kernel, *std::move(channels), std::move(known), job.settings()));
        std::vector<std::string> warnings;  // of the content: known
        SceneBuilder builder(scene, job, blobs, options.threads, self->tables_, warnings);
        if (auto s = builder.rebuild_view(); !s.ok()) return s;
        return self;
      }
    }
    auto content = build_content(scene, job, blobs, options, *kernel);
    if (!content.ok()) return content.status();
    if (options.contents) options.contents->add(key, *content);
    return std::unique_ptr<LoadedScene>(
        new LoadedScene(kernel, *std::move(channels), *std::move(content), job.settings()));
  }

  absl::StatusOr<wire::TileResult> render_tile(const TileRequest& tile, std::stop_token stop,
                                               RenderStats& stats) const override {
    if (tile.x0 >= tile.x1 || tile.y0 >= tile.y1 || tile.sample_begin >= tile.sample_end) {
      return absl::InvalidArgumentError("a tile without pixels or samples");
    }
    wire::TileResult result;
    result.x0 = tile.x0, result.y0 = tile.y0, result.x1 = tile.x1, result.y1 = tile.y1;
    result.sample_begin = tile.sample_begin, result.sample_end = tile.sample_end;
    result.channels = channels_;
    RenderStats own;
    const std::uint64_t ticks = kernel_->clock_ticks();
    const double start = thread_cpu_seconds();
    const bool finished = fill(result, tile, stop, own);
    // The counter runs on while the thread waits for a processor, evenly over the stages.
    const double cpu_nanoseconds = 1e9 * (thread_cpu_seconds() - start);
    own.times *= cpu_nanoseconds / static_cast<double>(std::max<std::uint64_t>(kernel_->clock_ticks() - ticks, 1));
    stats += own;
    if (!finished) return absl::CancelledError("the tile was stopped");
    return result;
  }

  Ceiling measure_ceiling(const TileRequest& tile) const override {
    Ceiling ceiling;
    RayLog log;
    for (const bool recording : {true, false}) {
      wire::TileResult result;
      result.x0 = tile.x0, result.y0 = tile.y0, result.x1 = tile.x1, result.y1 = tile.y1;
      result.channels = channels_;
      TileAccumulator film(result);
      ceiling.stats = {};
      const double start = thread_cpu_seconds();
      kernel_->render_path(tables_, tile, {}, film, ceiling.stats, recording ? &log : nullptr);
      ceiling.render_cpu_seconds = thread_cpu_seconds() - start;
    }
    ceiling.stats.times = {};  // in ticks
    const double start = thread_cpu_seconds();
    kernel_->replay_rays(tables_.accel, log);
    ceiling.replay_cpu_seconds = thread_cpu_seconds() - start;
    return ceiling;
  }

  const std::vector<std::string>& warnings() const override { return content_->warnings; }

  const std::vector<std::string>& material_names() const override { return content_->material_names; }

  std::size_t memory_bytes() const override {
    const ShapeTable& s = tables_.shapes;
    std::size_t bytes = content_->accelerator->memory_bytes() + sizeof(Vertex) * s.vertices.size() +
                        4 * s.triangles.size() + sizeof(ShapeRecord) * s.shapes.size() +
                        sizeof(InstanceRecord) * s.instances.size() + sizeof(Affine) * s.motion_steps.size() +
                        sizeof(LightRecord) * tables_.lights.lights.size();
    for (const Environment& e : tables_.lights.environments) bytes += 4 * e.texels.size();
    const TextureImage* last = nullptr;
    for (const TextureNode& node : tables_.textures.nodes) {
      if (node.image && node.image.get() != last)
        bytes += 4 * (node.image->texels8.size() + node.image->texels32.size());
      last = node.image.get();
    }
    return bytes;
  }

  const void* content() const override { return content_.get(); }

 private:
  LoadedScene(const Kernel* kernel, std::vector<wire::ChannelDesc> channels,
              std::shared_ptr<const SceneContent> content, const v1::RenderSettings& settings)
      : kernel_(kernel),
        channels_(std::move(channels)),
        content_(std::move(content)),
        noise_{.noise = settings.noise(), .samples = settings.spp()},
        tables_(content_->tables) {}

  static absl::StatusOr<std::shared_ptr<const SceneContent>> build_content(const v1::Scene& scene,
                                                                           const v1::JobSpec& job,
                                                                           const BlobSource& blobs,
                                                                           const LoadOptions& options,
                                                                           const Kernel& kernel) {
    auto content = std::make_shared<SceneContent>();
    SceneTables& tables = content->tables;
    SceneBuilder builder(scene, job, blobs, options.threads, tables, content->warnings);
    if (auto s = builder.build_tables(); !s.ok()) return s;
    if (options.geometry_read) options.geometry_read();
    // Images have nothing to do with the BVH. A worker of one thread uses one.
    std::future<absl::Status> images = std::async(options.threads > 1 ? std::launch::async : std::launch::deferred,
                                                  [&] { return builder.decode_images(); });
    auto built = Accelerator::build(tables.shapes, tables.textures, kernel.callbacks,
                                    {options.threads, options.isa, builder.wants_robust_intersection()});
    if (auto s = images.get(); !s.ok()) return s;
    if (!built.ok()) return built.status();
    const Accelerator& accelerator = *(content->accelerator = *std::move(built));
    tables.accel = accelerator.scene();
    for (const v1::Material& material : scene.materials()) content->material_names.push_back(material.name());
    content->material_names.resize(tables.materials.materials.size(), "(default)");
    std::copy_n(accelerator.bounding_centre(), 3, tables.lights.scene_centre);
    if (auto s = builder.check_instances(accelerator.bounding_centre(), accelerator.bounding_radius()); !s.ok())
      return s;
    if (auto s = builder.build_light_selection(accelerator.bounding_radius()); !s.ok()) return s;
    return content;
  }

  /// False when stopped.
  bool fill(wire::TileResult& result, const TileRequest& tile, std::stop_token stop, RenderStats& stats) const {
    if (noise_.noise > 0) {
      AdaptiveTile film(result, static_cast<std::uint32_t>(tables_.camera.width),
                        static_cast<std::uint32_t>(tables_.camera.height), noise_);
      return kernel_->render_samples(tables_, film, tile.seed_offset, stop, stats);
    }
    TileAccumulator film(result);
    return tables_.light_tracing ? kernel_->render_light(tables_, tile, stop, film, stats)
                                 : kernel_->render_path(tables_, tile, stop, film, stats, nullptr);
  }

  const Kernel* const kernel_;
  const std::vector<wire::ChannelDesc> channels_;
  const std::shared_ptr<const SceneContent> content_;
  const NoiseTarget noise_;
  SceneTables tables_;
};

}  // namespace

absl::Status SceneBuilder::build_tables() {
  for (const auto step : {&SceneBuilder::build_settings, &SceneBuilder::build_camera, &SceneBuilder::build_filter,
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
  for (const auto step : {&SceneBuilder::build_settings, &SceneBuilder::build_camera, &SceneBuilder::build_filter}) {
    if (auto s = (this->*step)(); !s.ok()) return s;
  }
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<RenderScene>> load_scene(const v1::Scene& scene, const v1::JobSpec& job,
                                                        const BlobSource& blobs, const LoadOptions& options) {
  return LoadedScene::load(scene, job, blobs, options);
}

}  // namespace tessera::render
