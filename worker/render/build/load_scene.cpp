#include "render/build/load_scene.h"

#include <algorithm>
#include <ctime>

#include "absl/strings/str_cat.h"
#include "render/accel/accelerator.h"
#include "render/build/scene_builder.h"
#include "render/film/tile_accumulator.h"
#include "render/integrator/kernel.h"
#include "wire/scene_numbers.h"

namespace tessera::render {

namespace {

double thread_cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

class LoadedScene final : public RenderScene {
 public:
  static absl::StatusOr<std::unique_ptr<RenderScene>> load(const v1::Scene& scene, const v1::JobSpec& job,
                                                           const BlobSource& blobs, const LoadOptions& options) {
    auto self = std::unique_ptr<LoadedScene>(new LoadedScene);
    self->kernel_ = find_kernel(options.isa);
    if (!self->kernel_) {
      return absl::FailedPreconditionError(
          absl::StrCat("this build or processor has no kernels for ISA '", options.isa, "'"));
    }
    auto channels = wire::channels_for_aovs({job.aovs().begin(), job.aovs().end()});
    if (!channels.ok()) return channels.status();
    self->channels_ = *std::move(channels);
    if (job.width() == 0 || job.height() == 0) return absl::InvalidArgumentError("the film has no pixels");

    if (auto s = wire::check_scene_numbers(scene); !s.ok()) return s;
    SceneBuilder builder(scene, job, blobs, options.threads, self->tables_, self->warnings_);
    if (auto s = builder.build_tables(); !s.ok()) return s;
    auto accelerator = Accelerator::build(self->tables_.shapes, self->tables_.textures, self->kernel_->callbacks,
                                          {options.threads, options.isa, builder.wants_robust_intersection()});
    if (!accelerator.ok()) return accelerator.status();
    self->accelerator_ = *std::move(accelerator);
    self->tables_.accel = self->accelerator_->scene();
    std::copy_n(self->accelerator_->bounding_centre(), 3, self->tables_.lights.scene_centre);
    if (auto s = builder.check_instances(self->accelerator_->bounding_centre(), self->accelerator_->bounding_radius());
        !s.ok())
      return s;
    if (auto s = builder.build_light_selection(self->accelerator_->bounding_radius()); !s.ok()) return s;
    return self;
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
    TileAccumulator film(result);
    const bool finished = tables_.light_tracing ? kernel_->render_light(tables_, tile, stop, film, stats)
                                                : kernel_->render_path(tables_, tile, stop, film, stats, nullptr);
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
    const double start = thread_cpu_seconds();
    kernel_->replay_rays(tables_.accel, log);
    ceiling.replay_cpu_seconds = thread_cpu_seconds() - start;
    return ceiling;
  }

  const std::vector<std::string>& warnings() const override { return warnings_; }

  std::size_t memory_bytes() const override {
    const ShapeTable& s = tables_.shapes;
    std::size_t bytes = accelerator_->memory_bytes() + sizeof(Vertex) * s.vertices.size() + 4 * s.triangles.size() +
                        sizeof(ShapeRecord) * s.shapes.size() + sizeof(InstanceRecord) * s.instances.size() +
                        sizeof(Affine) * s.motion_steps.size() + sizeof(LightRecord) * tables_.lights.lights.size();
    for (const Environment& e : tables_.lights.environments) bytes += 4 * e.texels.size();
    const TextureImage* last = nullptr;
    for (const TextureNode& node : tables_.textures.nodes) {
      if (node.image && node.image.get() != last)
        bytes += 4 * (node.image->texels8.size() + node.image->texels32.size());
      last = node.image.get();
    }
    return bytes;
  }

 private:
  LoadedScene() = default;

  const Kernel* kernel_ = nullptr;
  SceneTables tables_;
  std::vector<wire::ChannelDesc> channels_;
  std::vector<std::string> warnings_;
  std::unique_ptr<Accelerator> accelerator_;  // reads tables_: goes first
};

}  // namespace

absl::Status SceneBuilder::build_tables() {
  for (const auto step : {&SceneBuilder::build_settings, &SceneBuilder::build_camera, &SceneBuilder::build_filter,
                          &SceneBuilder::load_images, &SceneBuilder::build_textures, &SceneBuilder::build_media,
                          &SceneBuilder::build_materials, &SceneBuilder::build_shapes, &SceneBuilder::build_lights}) {
    if (auto s = (this->*step)(); !s.ok()) return s;
  }
  decide_volumetric();
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<RenderScene>> load_scene(const v1::Scene& scene, const v1::JobSpec& job,
                                                        const BlobSource& blobs, const LoadOptions& options) {
  return LoadedScene::load(scene, job, blobs, options);
}

}  // namespace tessera::render
