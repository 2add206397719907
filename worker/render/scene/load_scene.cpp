#include "render/scene/load_scene.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "base/cpu_time.h"
#include "render/accel/ray_log.h"
#include "render/accel/stoppable_query.h"
#include "render/core/stopped.h"
#include "render/film/fixed_tile.h"
#include "render/film/pass_film.h"
#include "render/film/scatter_tile.h"
#include "render/kernel/kernel_module.h"
#include "render/light/light_source.h"
#include "render/scene/light/unseen_light.h"
#include "render/scene/memory/heap_bytes.h"
#include "render/scene/memory/table_members.h"
#include "render/scene/noise_phase.h"
#include "render/scene/scene_content.h"
#include "render/scene/sharing_pilot.h"
#include "render/scene/view/layers.h"
#include "render/scene/view/lens.h"
#include "render/scene/view/view.h"
#include "wire/algorithm.h"
#include "wire/algorithm_fit.h"
#include "wire/aov_channels.h"
#include "wire/job_check.h"
#include "wire/scene_numbers.h"

namespace tessera::render {

namespace {

constexpr char kStopped[] = "stopped while the scene was built";

double thread_cpu_seconds() { return base::in_seconds(base::thread_cpu_time()); }

class BuiltScene final : public RenderScene {
 public:
  static absl::StatusOr<std::unique_ptr<RenderScene>> load(const v1::Scene& scene, const v1::JobSpec& job,
                                                           const BlobSource& blobs,
                                                           const LoadOptions& options) {
    const bool spectral = job.content().algorithms().color() == v1::COLOR_SPECTRAL;
    const auto found = kernel_of(options.isa, spectral ? KernelLight::kWavelengths : KernelLight::kRgb);
    if (!found.ok()) {
      return absl::FailedPreconditionError(absl::StrCat("there are no kernels for ISA '", options.isa, "'",
                                                        spectral ? " that carry light of wavelengths" : "",
                                                        " here: ", found.status().message()));
    }
    const Kernel* const kernel = *found;
    const wire::AlgorithmTraits* const traits = wire::find_algorithm(job.content().algorithms().integrator());
    const Algorithm* const algorithm = traits == nullptr ? nullptr : kernel->find(traits->name);
    if (algorithm == nullptr) {
      return absl::InvalidArgumentError(
          absl::StrCat("there is no integrator '", job.content().algorithms().integrator(), "' here"));
    }
    std::vector<wire::ChannelDesc> channels = wire::channels_of(job.view());
    if (scene.has_rig()) return absl::InvalidArgumentError("rig: it is for clients to resolve into views");
    if (job.view().width() == 0 || job.view().height() == 0)
      return absl::InvalidArgumentError("the film has no pixels");
    if (auto s = wire::check_scene_numbers(scene); !s.ok()) return s;
    if (auto s = wire::check_obstacles(job.content().algorithms(), scene); !s.ok()) return s;

    const std::string key = options.contents ? content_key(scene, job, options.isa) : "";
    if (options.contents) {
      if (auto known = std::static_pointer_cast<const SceneContent>(options.contents->find(key))) {
        auto self = std::unique_ptr<BuiltScene>(
            new BuiltScene(*kernel, *traits, *algorithm, std::move(channels), std::move(known), job));
        if (auto s = view_content(scene, job, blobs, self->tables_); !s.ok()) return s;
        if (options.geometry_read) options.geometry_read();
        return made_ready(std::move(self), scene, job, blobs, options.stop);
      }
    }
    auto build = ContentBuild::begin(scene, job, blobs, options, *kernel->accel, kernel->light_sources);
    if (!build.ok()) return build.status();
    auto content = build->finish();
    if (!content.ok()) return content.status();
    if (options.contents) options.contents->add(key, *content);
    auto self = std::unique_ptr<BuiltScene>(
        new BuiltScene(*kernel, *traits, *algorithm, std::move(channels), *std::move(content), job));
    return made_ready(std::move(self), scene, job, blobs, options.stop);
  }

  absl::StatusOr<wire::TileResult> render_tile(const TileRequest& tile, std::stop_token stop,
                                               RenderStats& stats) const override {
    if (tile.x0 >= tile.x1 || tile.y0 >= tile.y1 || tile.sample_begin >= tile.sample_end) {
      return absl::InvalidArgumentError("a tile without pixels or samples");
    }
    wire::TileResult result = empty_result(tile);
    const bool finished =
        timed(stats, [&](RenderStats& own) { return fill(result, tile, rays_until(stop), stop, own); });
    if (!finished) return absl::CancelledError("the tile was stopped");
    return result;
  }

  absl::StatusOr<std::shared_ptr<const Prepared>> prepare(
      std::span<const std::string_view> blobs) const override {
    if (blobs.empty()) return nullptr;
    if (noise_.noise > 0 && blobs.size() > algorithm_.phases.size()) {
      auto own = prepare(blobs.first(algorithm_.phases.size()));
      if (!own.ok()) return own.status();
      return prepare_noise(blobs.back(), *std::move(own), noise_, tables_, scatters());
    }
    std::shared_ptr<const Prepared> prepared =
        algorithm_.prepare == nullptr ? nullptr : algorithm_.prepare(tables_, blobs);
    if (prepared == nullptr) return absl::InvalidArgumentError("a blob is not what the phases make");
    return prepared;
  }

  absl::StatusOr<std::string> make_part(const PartRequest& part, const FilmRect& crop, std::stop_token stop,
                                        RenderStats& stats) const override {
    if (auto s = check_phase(part.phase); !s.ok()) return s;
    std::string blob;
    const StoppableQuery rays = rays_until(stop);
    const bool finished = timed(stats, [&](RenderStats& own) {
      IntegratorContext context{tables_, rays, tables_.sampler.seed + part.seed_offset, own, part.prepared};
      if (part.phase == algorithm_.phases.size()) {
        context.prepared = or_alone(part.prepared);
        return make_noise_pilot(algorithm_, context, part, crop, noise_, scatters(), group_, stop, blob);
      }
      return algorithm_.phases[part.phase].make(context, part, stop, blob);
    });
    if (finished) return blob;
    if (stop.stop_requested()) return absl::CancelledError("the part was stopped");
    return absl::InvalidArgumentError(absl::StrCat("phase ", part.phase, " of integrator '", traits_.name,
                                                   "' cannot be made of what the phases before have made"));
  }

  absl::StatusOr<std::string> merge(std::uint32_t phase,
                                    std::span<const std::string_view> blobs) const override {
    if (auto s = check_phase(phase); !s.ok()) return s;
    std::string merged;
    if (!(phase == algorithm_.phases.size() ? merge_noise_pilots(blobs, merged)
                                            : algorithm_.phases[phase].merge(blobs, merged))) {
      return absl::InvalidArgumentError(
          absl::StrCat("phase ", phase, " of integrator '", traits_.name, "' has not made these blobs"));
    }
    return merged;
  }

  absl::StatusOr<Ceiling> measure_ceiling(const TileRequest& tile, std::stop_token stop) const override {
    try {
      return measure_ceiling_until(stop, tile);
    } catch (const Stopped&) {
      return absl::CancelledError("the measurement was stopped");
    }
  }

  Structure structure() const override {
    return {content_->accelerator->figures(), content_->accelerator_cpu_seconds};
  }

  const std::vector<std::string>& warnings() const override { return warnings_; }

  std::string unseen_light(const std::string& algorithm) const override {
    const auto found = unseen_light_by_algorithm_.find(algorithm);
    return found == unseen_light_by_algorithm_.end() ? "" : found->second;
  }

  std::array<double, 3> emitted_flux(std::int32_t rays) const override {
    static_assert(kBands == 3);
    const LightTable& table = tables_.lights;
    std::array<double, 3> sum{};
    for (std::size_t i = 0; i < table.lights.size(); ++i) {
      const LightRecord& light = table.lights[i];
      if (light.same_as >= 0 || table.sources(light.kind).traits.at_infinity) continue;
      const auto flux = table.sources(light.kind).emitted_flux(table, static_cast<std::int32_t>(i), rays);
      for (std::size_t band = 0; band < sum.size(); ++band) sum[band] += flux[band];
    }
    return sum;
  }

  std::vector<std::string> notes() const override {
    std::vector<std::string> notes = content_->notes;
    if (sharing_ == v1::PATH_SHARING_AUTO && !unshared_because_.empty()) notes.push_back(unshared_message());
    if (too_little_by_sharing_) {
      notes.push_back(absl::StrFormat(
          "pixels do not share light: a pilot finds %.2f times the efficiency (standard error %.0f %%)",
          too_little_by_sharing_->gain(), 100 * too_little_by_sharing_->error));
    }
    return notes;
  }

  const std::vector<std::string>& material_names() const override { return content_->material_names; }

  std::size_t memory_bytes() const override {
    HeapBytes bytes;
    bytes.add(tables_);
    bytes.add(content_->shape_numbers);
    for (const auto* texts : {&content_->warnings, &content_->notes, &content_->material_names})
      bytes.add(*texts);
    return content_->accelerator->memory_bytes() + bytes.total();
  }

  const void* content() const override { return content_.get(); }

 private:
  /// With the job's layers, and what its algorithm prepares without phases.
  static absl::StatusOr<std::unique_ptr<RenderScene>> made_ready(std::unique_ptr<BuiltScene> self,
                                                                 const v1::Scene& scene,
                                                                 const v1::JobSpec& job,
                                                                 const BlobSource& blobs,
                                                                 const std::stop_token& stop) {
    throw_if_stopped(stop);
    if (auto s = focus_view(scene, job, blobs, self->content_->arrays, *self->content_->rays, self->tables_);
        !s.ok())
      return s;
    if (!job.view().layers().empty()) {
      auto layers = build_layers(scene, wire::layers_of(job.view()), self->traits_.layers,
                                 self->content_->shape_numbers, self->content_->arrays);
      if (!layers.ok()) return layers.status();
      self->tables_.layers = *std::move(layers);
    }
    for (const wire::AlgorithmTraits& one : wire::algorithms()) {
      std::string unseen = render::unseen_light(one, self->tables_, scene, self->content_->material_names);
      if (!unseen.empty()) self->unseen_light_by_algorithm_[one.name] = std::move(unseen);
    }
    if (std::string unseen = self->unseen_light(self->traits_.name); !unseen.empty())
      self->warnings_.push_back(std::move(unseen));
    if (std::string dark = dark_film_warning(scene.camera(), self->tables_.sensor); !dark.empty())
      self->warnings_.push_back(std::move(dark));
    self->prepare_alone();
    self->find_group(stop);
    return self;
  }

  BuiltScene(const Kernel& kernel, const wire::AlgorithmTraits& traits, const Algorithm& algorithm,
             std::vector<wire::ChannelDesc> channels, std::shared_ptr<const SceneContent> content,
             const v1::JobSpec& job)
      : kernel_(kernel),
        traits_(traits),
        algorithm_(algorithm),
        channels_(std::move(channels)),
        content_(std::move(content)),
        noise_{.noise = job.samples().noise(), .samples = job.samples().spp()},
        in_passes_(wire::works_in_passes(job)),
        may_scatter_(job.view().reconstruction() == v1::RECONSTRUCTION_SCATTER),
        sharing_(job.view().path_sharing()),
        tables_(content_->tables) {}

  /// Names the part of the scene that keeps pixels from sharing light; empty where there is none. Sharing
  /// needs the transmittance between two surfaces as one number, the same for all bands.
  std::string_view find_what_shares_nothing() const {
    if (!tables_.paths_pass) return "";
    if (!tables_.media.media.empty()) return "media";
    const auto is_tinted_sheet = [](const MaterialRecord& material) {
      return (material.flags & kPassesStraight) != 0 &&
             ((material.variants & kTinted) != 0 || (material.flags & kDisperses) != 0);
    };
    const auto has_holes = [](const ShapeRecord& shape) { return (shape.flags & kHasAlpha) != 0; };
    if (std::ranges::any_of(tables_.materials.materials, is_tinted_sheet)) return "tinted sheets of glass";
    if (std::ranges::any_of(tables_.shapes.shapes, has_holes))
      return "shapes with holes beside materials of some opacity";
    return "";
  }

  std::string unshared_message() const {
    return absl::StrCat("pixels do not share light: the scene has ", std::string(unshared_because_));
  }

  void find_group(const std::stop_token& stop) {
    unshared_because_ = find_what_shares_nothing();
    if (!unshared_because_.empty()) {
      if (sharing_ > v1::PATH_SHARING_OFF) warnings_.push_back(unshared_message());
      return;
    }
    if (tables_.max_depth < 2) return;
    // Spread, so that neighbours that a filter weighs together are of several groups.
    constexpr std::uint32_t kStep = 2;
    constexpr PixelGroup kFour{2, 2, kStep}, kEight{4, 2, kStep}, kSixteen{4, 4, kStep};
    const auto pilot_of = [&](const PixelGroup& group) {
      return make_sharing_pilot(algorithm_, tables_, rays_until(stop), prepared_alone_.get(), scatters(),
                                group);
    };
    SharingPilot pilot;
    switch (sharing_) {
      case v1::PATH_SHARING_4:
        pilot = pilot_of(group_ = kFour);
        break;
      case v1::PATH_SHARING_8:
        pilot = pilot_of(group_ = kEight);
        break;
      case v1::PATH_SHARING_16:
        pilot = pilot_of(group_ = kSixteen);
        break;
      case v1::PATH_SHARING_AUTO:
        pilot = pilot_of(kEight);
        if (!pilot.pays()) {
          too_little_by_sharing_ = pilot;
          return;
        }
        group_ = kEight;
        if (const SharingPilot of_sixteen = pilot_of(kSixteen); of_sixteen.beats(pilot))
          group_ = kSixteen, pilot = of_sixteen;
        break;
      default:
        return;
    }
    tables_.shared_caution = pilot.caution();
    if (tables_.sampler.kind == SamplerKind::kSobol) tables_.sampler.kind = SamplerKind::kGroupSobol;
  }

  /// Prepares what an algorithm without phases makes of the scene alone.
  void prepare_alone() {
    if (algorithm_.phases.empty() && algorithm_.prepare != nullptr)
      prepared_alone_ = algorithm_.prepare(tables_, {});
  }

  /// Returns what the algorithm reads where its phases have made `prepared`, or it has none.
  const Prepared* or_alone(const Prepared* prepared) const {
    return prepared != nullptr ? prepared : prepared_alone_.get();
  }

  /// The rays of work that may be stopped; `stop` outlives them.
  StoppableQuery rays_until(const std::stop_token& stop) const {
    return {*content_->rays, content_->accelerator->shadow_rays_at_a_time(), stop};
  }

  Ceiling measure_ceiling_until(const std::stop_token& stop, const TileRequest& tile) const {
    Ceiling ceiling;
    RayLog log;
    const StoppableQuery all = rays_until(stop);
    const RecordingQuery recorder(all, log);
    const RayQuery* const asked[] = {&recorder, &all};
    for (const RayQuery* rays : asked) {
      wire::TileResult result = empty_result(tile);
      ceiling.stats = {};
      const double start = thread_cpu_seconds();
      fill(result, tile, *rays, stop, ceiling.stats);
      ceiling.render_cpu_seconds = thread_cpu_seconds() - start;
    }
    ceiling.stats.times = {};  // ticks, not nanoseconds
    for (int kind = 0; kind < kRayKinds; ++kind) {
      Ceiling::Rays& rays = ceiling.rays[static_cast<std::size_t>(kind)];
      const RayVisits before = content_->rays->visits();
      const double start = thread_cpu_seconds();
      rays.count = replay(all, log, static_cast<RayKind>(kind)).rays;
      rays.cpu_seconds = thread_cpu_seconds() - start;
      rays.visits = content_->rays->visits() - before;
    }
    return ceiling;
  }

  /// Whether samples go into several pixels.
  bool scatters() const {
    return may_scatter_ && filter_reach(tables_.filter.x) + filter_reach(tables_.filter.y) > 0;
  }

  wire::TileResult empty_result(const TileRequest& tile) const {
    wire::TileResult result;
    result.x0 = tile.x0, result.y0 = tile.y0, result.x1 = tile.x1, result.y1 = tile.y1;
    result.sample_begin = tile.sample_begin, result.sample_end = tile.sample_end;
    result.channels = channels_;
    return result;
  }

  absl::Status check_phase(std::uint32_t phase) const {
    const std::size_t phases = algorithm_.phases.size() + (noise_.noise > 0 ? 1 : 0);
    if (phase < phases) return absl::OkStatus();
    return absl::InvalidArgumentError(
        absl::StrCat("integrator '", traits_.name, "' has ", phases, " phases, not ", phase + 1));
  }

  /// Returns the result of `work`, and adds its counts to `stats`, with ticks made into CPU time. False where
  /// the work is stopped.
  template <class Work>
  bool timed(RenderStats& stats, Work work) const {
    RenderStats own;
    const std::uint64_t ticks = kernel_.clock_ticks();
    const double start = thread_cpu_seconds();
    bool finished = false;
    try {
      finished = work(own);
    } catch (const Stopped&) {
    }
    // The counter runs on while the thread waits for a processor, evenly over the stages.
    const double cpu_nanoseconds = 1e9 * (thread_cpu_seconds() - start);
    own.times *=
        cpu_nanoseconds / static_cast<double>(std::max<std::uint64_t>(kernel_.clock_ticks() - ticks, 1));
    stats += own;
    return finished;
  }

  /// False when stopped.
  bool fill(wire::TileResult& result, const TileRequest& tile, const RayQuery& rays, std::stop_token stop,
            RenderStats& stats) const {
    const Prepared* prepared = tile.prepared;
    // Without its pilot, a picture takes all samples everywhere.
    const SampleCounts* counts = nullptr;
    if (const auto* const noise = dynamic_cast<const NoisePrepared*>(prepared)) {
      counts = &noise->counts;
      prepared = noise->algorithm.get();
    }
    const auto integrator =
        algorithm_.make({tables_, rays, tables_.sampler.seed + tile.seed_offset, stats, or_alone(prepared)});
    const FilmSize size{static_cast<std::uint32_t>(tables_.sensor.width),
                        static_cast<std::uint32_t>(tables_.sensor.height)};
    if (in_passes_) {
      PassFilm film(result, tables_.filter, static_cast<std::size_t>(tables_.layers.count),
                    static_cast<std::size_t>(tables_.sensor.response.sensitivity.bands),
                    edges_of(tables_.sensor), size);
      while (film.begin_pass()) {
        if (!integrator->render(film, film, stop)) return false;
        film.end_pass();
      }
      return true;
    }
    if (scatters() || group_.count() > 1) {
      ScatterTile film(result, scatters() ? &tables_.filter : nullptr,
                       tables_.sampler.seed + tile.seed_offset, counts, group_, size);
      const std::uint64_t samples = stats.samples;
      const bool finished = integrator->render(film, film, stop);
      // Those of the border, and of neighbours beyond it, are none of the picture's.
      stats.samples = std::accumulate(result.counts.begin(), result.counts.end(), samples);
      return finished;
    }
    FixedTile film(result, counts);
    return integrator->render(film, film, stop);
  }

  const Kernel& kernel_;
  const wire::AlgorithmTraits& traits_;
  const Algorithm& algorithm_;
  const std::vector<wire::ChannelDesc> channels_;
  const std::shared_ptr<const SceneContent> content_;
  const NoiseTarget noise_;
  const bool in_passes_;
  const bool may_scatter_;
  const v1::PathSharing sharing_;
  PixelGroup group_;                   // neighbours that share light
  std::string_view unshared_because_;  // the scene has this; empty: its pixels may share light
  std::optional<SharingPilot> too_little_by_sharing_;
  SceneTables tables_;
  std::vector<std::string> warnings_ = content_->warnings;
  std::map<std::string, std::string> unseen_light_by_algorithm_;
  std::unique_ptr<const Prepared> prepared_alone_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<RenderScene>> load_scene(const v1::Scene& scene, const v1::JobSpec& job,
                                                        const BlobSource& blobs, const LoadOptions& options) {
  const BlobSource until_stopped = [&](const std::string& digest) -> absl::StatusOr<BlobBytes> {
    if (options.stop.stop_requested()) return absl::CancelledError(kStopped);
    return blobs(digest);
  };
  try {
    return BuiltScene::load(scene, job, until_stopped, options);
  } catch (const Stopped&) {
    return absl::CancelledError(kStopped);
  }
}

}  // namespace tessera::render
