#include "agent/unit_renderer.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <limits>
#include <mutex>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "base/cpu_time.h"
#include "telemetry/log.h"
#include "telemetry/metrics.h"
#include "tessera/v1/scene.pb.h"
#include "wire/digest.h"
#include "wire/job_check.h"
#include "wire/scene_views.h"
#include "wire/tile_result.h"
#include "wire/unit_counts.h"

namespace tessera::agent {
namespace {

constexpr int kMaxWarningsPerUnit = 8;  // job.proto

void set_duration(std::chrono::nanoseconds duration, google::protobuf::Duration& message) {
  message.set_seconds(duration.count() / 1'000'000'000);
  message.set_nanos(static_cast<std::int32_t>(duration.count() % 1'000'000'000));
}

std::size_t half_of_memory() {
  const long pages = ::sysconf(_SC_PHYS_PAGES), page_bytes = ::sysconf(_SC_PAGESIZE);
  return pages > 0 && page_bytes > 0
             ? static_cast<std::size_t>(pages) * static_cast<std::size_t>(page_bytes) / 2
             : SIZE_MAX;
}

/// Blobs as the builder asks for them. The first that it asks for starts the fetching of all others, beside
/// the building.
class BlobsOnDemand {
 public:
  BlobsOnDemand(base::Clock& clock, BlobFetcher& fetcher, const v1::JobSpec& spec, std::stop_token stop)
      : clock_(clock), fetcher_(fetcher), spec_(spec), stop_(std::move(stop)) {}

  absl::StatusOr<render::BlobBytes> get(const std::string& digest) {
    std::call_once(begun_, [this] {
      ahead_ = clock_.start("prefetch", [this](std::stop_token no_longer_needed) {
        std::stop_source either;
        const auto stop = [&] { either.request_stop(); };
        const std::stop_callback on_end{no_longer_needed, stop}, on_stop{stop_, stop};
        fetcher_.prefetch(spec_, either.get_token());
      });
    });
    return fetcher_.get(digest, stop_);
  }

 private:
  base::Clock& clock_;
  BlobFetcher& fetcher_;
  const v1::JobSpec& spec_;
  const std::stop_token stop_;
  std::once_flag begun_;
  base::Thread ahead_;
};

std::uint64_t count_of(std::chrono::nanoseconds time) {
  return static_cast<std::uint64_t>(std::max(time.count(), std::chrono::nanoseconds::rep{0}));
}

void add_times(const render::StageTimes& times, const std::vector<std::string>& materials,
               v1::UnitStats& stats) {
  for (std::size_t i = 0; i < times.stages.size(); ++i) {
    (*stats.mutable_stage_ns())[render::kStageNames[i]] = times.stages[i];
  }
  for (std::size_t i = 0; i < times.shading_parts.size(); ++i) {
    (*stats.mutable_shading_part_ns())[render::kShadingPartNames[i]] = times.shading_parts[i];
  }
  for (std::size_t i = 0; i < std::min(times.materials.size(), materials.size()); ++i) {
    if (times.materials[i] > 0) (*stats.mutable_material_ns())[materials[i]] += times.materials[i];
  }
}

void add_warnings(const std::vector<std::string>& warnings, v1::UnitStats& stats) {
  for (const std::string& warning : warnings) {
    if (stats.warnings_size() == kMaxWarningsPerUnit) return;
    stats.add_warnings(warning);
  }
}

/// Its result is the digest of the bytes.
void set_blob(std::string blob, Outcome& outcome) {
  v1::BlobRef ref;
  ref.set_digest(wire::sha256_hex(blob));
  ref.set_size_bytes(blob.size());
  outcome.payload = ref.SerializeAsString();
  outcome.blob = std::move(blob);
}

}  // namespace

UnitRenderer::UnitRenderer(const AgentOptions& options, CoordinatorLink& link, BlobFetcher* fetcher)
    : options_(options),
      clock_(*options.clock),
      fetcher_(fetcher),
      scenes_(
          clock_,
          [this](const v1::JobSpec& spec, std::uint32_t view, std::stop_token stop) {
            return load(spec, view, stop);
          },
          options.scenes_kept,
          options.scene_memory_cap_bytes > 0 ? options.scene_memory_cap_bytes : half_of_memory()),
      prepared_(clock_, link, fetcher),
      time_limit_(clock_, options.unit_limit) {
  report_.units_by_seconds.resize(telemetry::kUnitSecondsBuckets.size() + 1);
}

Outcome UnitRenderer::render(std::shared_ptr<HeldUnit> unit) {
  Outcome outcome;
  outcome.unit = std::move(unit);
  try {
    outcome.failure = render_unit(*outcome.unit, outcome);
  } catch (const std::exception& error) {  // out of memory, above all
    outcome.failure = absl::ResourceExhaustedError(absl::StrCat("rendering: ", error.what()));
  }
  if (outcome.unit->stop.stop_requested()) {
    outcome.failure = absl::CancelledError("the lease was revoked");
  }
  if (!outcome.failure.ok()) {
    std::lock_guard lock{mutex_};
    ++(absl::IsCancelled(outcome.failure) ? report_.units_stopped : report_.units_failed);
  }
  return outcome;
}

absl::Status UnitRenderer::make(const HeldUnit& held, const std::shared_ptr<const LoadedScene>& scene,
                                std::stop_token stop, Outcome& outcome, render::RenderStats& counts) {
  const v1::WorkUnit& unit = held.unit;
  const v1::JobSpec& spec = *held.spec;
  if (unit.has_merge()) {
    const absl::StatusOr<Inputs> inputs = prepared_.fetch(held.job_id, unit, stop);
    if (!inputs.ok()) return inputs.status();
    absl::StatusOr<std::string> merged = scene->scene->merge(unit.merge().phase(), inputs->blob_contents);
    if (!merged.ok()) return merged.status();
    set_blob(*std::move(merged), outcome);
    return absl::OkStatus();
  }
  const absl::StatusOr<std::shared_ptr<const render::Prepared>> prepared =
      prepared_.get(held.job_id, unit, scene, stop);
  if (!prepared.ok()) return prepared.status();
  if (unit.has_part()) {
    const int phase = static_cast<int>(unit.part().phase());
    if (phase >= spec.cut().phases_size()) return absl::InvalidArgumentError("the job has no such phase");
    const v1::PixelRect& crop = spec.cut().crop();
    absl::StatusOr<std::string> blob =
        scene->scene->make_part({.phase = unit.part().phase(),
                                 .part = unit.part().part(),
                                 .parts = spec.cut().phases(phase).parts(),
                                 .prepared = prepared->get()},
                                {crop.x0(), crop.y0(), crop.x1(), crop.y1()}, stop, counts);
    if (!blob.ok()) return blob.status();
    set_blob(*std::move(blob), outcome);
    return absl::OkStatus();
  }
  // A pass covers the whole crop.
  const v1::PixelRect& pixels = unit.has_pass() ? spec.cut().crop() : unit.tile().pixels();
  const v1::SampleRange& samples = unit.has_pass() ? unit.pass().passes() : unit.tile().samples();
  const render::TileRequest request{
      .x0 = pixels.x0(),
      .y0 = pixels.y0(),
      .x1 = pixels.x1(),
      .y1 = pixels.y1(),
      .sample_begin = samples.begin(),
      .sample_end = samples.end(),
      .prepared = prepared->get(),
  };
  const absl::StatusOr<wire::TileResult> result = scene->scene->render_tile(request, stop, counts);
  if (!result.ok()) return result.status();
  const std::chrono::nanoseconds encode_start = base::thread_cpu_time();
  outcome.payload =
      wire::encode_tile_result(*result, options_.plain_results ? wire::Packing::kNone : wire::Packing::kZstd);
  (*outcome.stats.mutable_stage_ns())["encode"] = count_of(base::thread_cpu_time() - encode_start);
  return absl::OkStatus();
}

absl::Status UnitRenderer::render_unit(const HeldUnit& unit, Outcome& outcome) {
  const std::stop_token stop = unit.stop.get_token();
  if (unit.unit.work_case() == v1::WorkUnit::WORK_NOT_SET)
    return absl::UnimplementedError("this worker knows tiles, passes, parts and merges only");

  const absl::StatusOr<std::shared_ptr<const LoadedScene>> loaded =
      scenes_.get(*unit.spec, wire::view_of(unit.unit), stop);
  if (!loaded.ok()) {
    outcome.scene_fault = absl::IsInvalidArgument(loaded.status());
    return loaded.status();
  }

  const base::Clock::TimePoint start = clock_.now();
  const std::chrono::nanoseconds cpu_start = base::thread_cpu_time();
  render::RenderStats counts;
  const TimeLimit::Watch watch(time_limit_, stop);
  const absl::Status made = make(unit, *loaded, watch.token(), outcome, counts);
  if (!made.ok() && watch.expired()) {
    return absl::DeadlineExceededError(absl::StrCat(
        "the unit took longer than ", std::chrono::ceil<std::chrono::seconds>(options_.unit_limit).count(),
        " s, the worker's --unit-limit"));
  }
  if (!made.ok()) {
    outcome.inputs_fault = absl::IsInvalidArgument(made) && unit.unit.inputs_size() > 0;
    return made;
  }

  wire::set_counts(counts, outcome.stats);
  add_times(counts.times, (*loaded)->scene->material_names(), outcome.stats);
  add_warnings(counts.warnings, outcome.stats);
  // Every job hears once what its scene asked for in vain.
  if (unit.unit.index() == 0) {
    add_warnings((*loaded)->scene->warnings(), outcome.stats);
    for (const std::string& note : (*loaded)->scene->notes()) outcome.stats.add_notes(note);
  }
  set_duration(base::thread_cpu_time() - cpu_start, *outcome.stats.mutable_cpu_time());
  const auto taken = clock_.now() - start;
  set_duration(taken, *outcome.stats.mutable_wall_time());

  telemetry::log(spdlog::level::debug, unit.log_fields(), "unit {} of job {} rendered", unit.unit.index(),
                 unit.job_id);

  std::lock_guard lock{mutex_};
  ++report_.units_rendered;
  const double seconds = base::in_seconds(taken);
  report_.rendered_unit_seconds += seconds;
  const auto bucket =
      std::lower_bound(telemetry::kUnitSecondsBuckets.begin(), telemetry::kUnitSecondsBuckets.end(), seconds);
  ++report_.units_by_seconds[static_cast<std::size_t>(bucket - telemetry::kUnitSecondsBuckets.begin())];
  if (const auto cost = untold_costs_.extract((*loaded)->scene.get())) {
    (*outcome.stats.mutable_stage_ns())["fetch"] = count_of(cost.mapped().fetch_cpu);
    (*outcome.stats.mutable_stage_ns())["build"] = count_of(cost.mapped().build_cpu);
    outcome.stats.set_blob_bytes_fetched(cost.mapped().blob_bytes);
  }
  return absl::OkStatus();
}

absl::StatusOr<LoadedScene> UnitRenderer::load(const v1::JobSpec& spec, std::uint32_t view,
                                               std::stop_token stop) {
  if (auto s = wire::check_settings(spec); !s.ok()) return s;
  const base::Clock::TimePoint start = clock_.now();
  const std::chrono::nanoseconds cpu_start = base::process_cpu_time();
  const std::string& digest = spec.content().scene();
  std::optional<BlobsOnDemand> on_demand;
  render::BlobSource blobs = options_.blobs;
  if (!blobs) {
    on_demand.emplace(clock_, *fetcher_, spec, stop);
    blobs = [&on_demand](const std::string& name) { return on_demand->get(name); };
  }
  const auto blob_bytes = std::make_shared<std::atomic<std::uint64_t>>(0);  // asked for from several threads
  blobs = [blob_bytes, source = std::move(blobs)](const std::string& name) {
    absl::StatusOr<render::BlobBytes> found = source(name);
    if (found.ok()) *blob_bytes += found->bytes.size();
    return found;
  };
  // Not through `on_demand`: whether anything else is needed is known once the scene has been read.
  const absl::StatusOr<render::BlobBytes> bytes =
      fetcher_ != nullptr ? fetcher_->get(digest, stop) : blobs(digest);
  if (!bytes.ok()) return bytes.status();
  if (fetcher_ != nullptr) *blob_bytes += bytes->bytes.size();
  v1::Scene scene;
  if (bytes->bytes.size() > std::numeric_limits<int>::max() ||
      !scene.ParseFromArray(bytes->bytes.data(), static_cast<int>(bytes->bytes.size()))) {
    return absl::InvalidArgumentError(absl::StrCat("blob ", digest, " is not a scene"));
  }
  if (absl::Status status = wire::keep_view(view, scene); !status.ok()) return status;

  const base::Clock::TimePoint build_start = clock_.now();
  const std::chrono::nanoseconds cpu_build_start = base::process_cpu_time();
  const std::string isa = spec.farm().isa().empty() ? options_.isas.front() : spec.farm().isa();
  if (std::find(options_.isas.begin(), options_.isas.end(), isa) == options_.isas.end()) {
    return absl::FailedPreconditionError(
        absl::StrCat("the job wants ISA '", isa, "', which this worker does not have"));
  }
  v1::JobSpec of_view = spec;
  of_view.mutable_view()->set_seed(wire::seed_of(spec, view));
  absl::StatusOr<std::unique_ptr<render::RenderScene>> built = options_.load_scene(
      scene, of_view, blobs, {.isa = isa, .threads = options_.threads, .contents = &contents_, .stop = stop});
  if (!built.ok()) return built.status();

  const base::Clock::TimePoint end = clock_.now();
  LoadedScene loaded{*std::move(built), base::in_seconds(end - start), base::in_seconds(end - build_start)};
  loaded.bytes = loaded.scene->memory_bytes();
  loaded.content = loaded.scene->content();
  spdlog::info("scene {} ({}): loaded in {:.2f} s, {:.1f} MB", digest.substr(0, 12), scene.name(),
               loaded.load_seconds, static_cast<double>(loaded.bytes) * 1e-6);
  for (const std::string& warning : loaded.scene->warnings()) {
    spdlog::warn("scene {}: {}", digest.substr(0, 12), warning);
  }
  std::lock_guard lock{mutex_};
  untold_costs_[loaded.scene.get()] = {cpu_build_start - cpu_start,
                                       base::process_cpu_time() - cpu_build_start, *blob_bytes};
  report_.load_seconds += loaded.load_seconds;
  report_.build_seconds += loaded.build_seconds;
  report_.scene_bytes = std::max(report_.scene_bytes, loaded.bytes);
  for (const v1::BlobRef& blob : spec.farm().blobs()) report_.referenced_bytes += blob.size_bytes();
  ++report_.scenes_loaded;
  return loaded;
}

AgentReport UnitRenderer::report() const {
  std::lock_guard lock{mutex_};
  AgentReport report = report_;
  report.scenes_shared = contents_.shared();
  const SceneStore::Held held = scenes_.held();
  report.scenes_held = held.scenes;
  report.scene_bytes_held = held.bytes;
  if (fetcher_ != nullptr) fetcher_->add_to(report);
  return report;
}

}  // namespace tessera::agent
