#include "local/bench_scene.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "base/cpu_time.h"
#include "local/scene_blobs.h"
#include "render/scene/diffuse/radiosity_mesh.h"
#include "render/scene/load_scene.h"
#include "tessera/v1/scene.pb.h"
#include "wire/algorithm.h"
#include "wire/job_check.h"

namespace tessera::client {
namespace {

BenchCost cost_of(const render::RenderStats& stats, double cpu_seconds) {
  BenchCost cost{.cpu_seconds = cpu_seconds, .counts = stats, .stage_seconds = {}};
  for (std::size_t i = 0; i < stats.times.stages.size(); ++i) {
    cost.stage_seconds[render::kStageNames[i]] = 1e-9 * static_cast<double>(stats.times.stages[i]);
  }
  return cost;
}

/// Squares of `side` pixels that cover the crop.
std::vector<render::TileRequest> tiles_of(const v1::PixelRect& crop, std::uint32_t side) {
  std::vector<render::TileRequest> tiles;
  for (std::uint32_t y = crop.y0() / side * side; y < crop.y1(); y += side) {
    for (std::uint32_t x = crop.x0() / side * side; x < crop.x1(); x += side) {
      tiles.push_back({std::max(x, crop.x0()), std::max(y, crop.y0()), std::min(x + side, crop.x1()),
                       std::min(y + side, crop.y1()), 0, 0});
    }
  }
  return tiles;
}

/// Merges blobs of a phase, `width` neighbours at a time, until one is left (scheduler/phase_plan.h).
absl::StatusOr<std::string> merge_all(const render::RenderScene& scene, std::uint32_t phase,
                                      std::vector<std::string> blobs, std::uint32_t width) {
  while (blobs.size() > 1) {
    std::vector<std::string> merged;
    for (std::size_t first = 0; first < blobs.size(); first += width) {
      const std::size_t end = std::min<std::size_t>(first + width, blobs.size());
      const std::vector<std::string_view> group(blobs.begin() + static_cast<std::ptrdiff_t>(first),
                                                blobs.begin() + static_cast<std::ptrdiff_t>(end));
      absl::StatusOr<std::string> blob = scene.merge(phase, group);
      if (!blob.ok()) return blob.status();
      merged.push_back(*std::move(blob));
    }
    blobs = std::move(merged);
  }
  return std::move(blobs.front());
}

}  // namespace

BenchCost& BenchCost::operator+=(const BenchCost& other) {
  cpu_seconds += other.cpu_seconds;
  counts += other.counts;
  for (const auto& [stage, seconds] : other.stage_seconds) stage_seconds[stage] += seconds;
  return *this;
}

std::shared_ptr<render::SharedContents> make_shared_contents() {
  return std::make_shared<render::SharedContents>();
}

struct BenchScene::Parts {
  std::unique_ptr<render::RenderScene> scene;
  google::protobuf::RepeatedPtrField<v1::Phase> phases;
  render::FilmRect crop;
  std::vector<render::TileRequest> tiles;
};

BenchScene::BenchScene(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
BenchScene::~BenchScene() = default;

const std::vector<std::string>& BenchScene::warnings() const { return parts_->scene->warnings(); }
std::string BenchScene::unseen_light(const std::string& integrator) const {
  return parts_->scene->unseen_light(integrator);
}
std::array<double, 3> BenchScene::emitted_flux(std::int32_t rays) const {
  return parts_->scene->emitted_flux(rays);
}

absl::StatusOr<std::unique_ptr<BenchScene>> BenchScene::load(const v1::JobSpec& spec,
                                                             const std::vector<const SceneBlob*>& blobs,
                                                             int threads, render::SharedContents* contents,
                                                             std::stop_token stop) {
  const std::chrono::nanoseconds start = base::process_cpu_time();
  const SceneBlobs source(blobs);
  const absl::StatusOr<render::BlobBytes> bytes = source.bytes(spec.content().scene());
  if (!bytes.ok()) return bytes.status();
  v1::Scene message;
  if (!message.ParseFromArray(bytes->bytes.data(), static_cast<int>(bytes->bytes.size()))) {
    return absl::InternalError("the scene's own message cannot be read");
  }
  absl::StatusOr<std::unique_ptr<render::RenderScene>> scene =
      render::load_scene(message, spec, [&](const std::string& digest) { return source.bytes(digest); },
                         {.isa = spec.farm().isa(), .threads = threads, .contents = contents, .stop = stop});
  if (!scene.ok()) return scene.status();

  auto parts = std::make_unique<Parts>();
  parts->scene = *std::move(scene);
  parts->phases = spec.cut().phases();
  const v1::PixelRect& crop = spec.cut().crop();
  parts->crop = {crop.x0(), crop.y0(), crop.x1(), crop.y1()};
  // A pass goes over the whole film.
  parts->tiles = tiles_of(spec.cut().crop(), wire::works_in_passes(spec)
                                                 ? std::max(spec.view().width(), spec.view().height())
                                                 : spec.cut().tile_size());
  std::unique_ptr<BenchScene> self{new BenchScene{std::move(parts)}};
  self->build_cpu_seconds_ = base::in_seconds(base::process_cpu_time() - start);
  return self;
}

absl::StatusOr<BenchPhases> BenchScene::make_phases(std::uint64_t seed_offset, std::stop_token stop) const {
  const std::chrono::nanoseconds start = base::thread_cpu_time();
  render::RenderStats stats;
  BenchPhases made;
  std::vector<std::string> results;  // a blob a phase
  for (int phase = 0; phase < parts_->phases.size(); ++phase) {
    const auto index = static_cast<std::uint32_t>(phase);
    std::vector<std::string> blobs;
    for (std::uint32_t part = 0; part < parts_->phases[phase].parts(); ++part) {
      absl::StatusOr<std::string> blob = parts_->scene->make_part(
          {index, part, parts_->phases[phase].parts(), made.prepared.get(), seed_offset}, parts_->crop, stop,
          stats);
      if (!blob.ok()) return blob.status();
      blobs.push_back(*std::move(blob));
    }
    absl::StatusOr<std::string> merged =
        merge_all(*parts_->scene, index, std::move(blobs), parts_->phases[phase].merge_width());
    if (!merged.ok()) return merged.status();
    results.push_back(*std::move(merged));
    absl::StatusOr<std::shared_ptr<const render::Prepared>> prepared =
        parts_->scene->prepare(std::vector<std::string_view>(results.begin(), results.end()));
    if (!prepared.ok()) return prepared.status();
    made.prepared = *std::move(prepared);
  }
  if (!results.empty()) made.last = std::move(results.back());
  made.cost = cost_of(stats, base::in_seconds(base::thread_cpu_time() - start));
  return made;
}

absl::StatusOr<LitMesh> BenchScene::radiosity_mesh(const v1::Scene& scene, std::stop_token stop) const {
  const absl::StatusOr<BenchPhases> phases = make_phases(0, stop);
  if (!phases.ok()) return phases.status();
  absl::StatusOr<render::RadiosityMesh> mesh = render::read_radiosity_mesh(scene, phases->last);
  if (!mesh.ok()) return mesh.status();
  return LitMesh{std::move(mesh->positions), std::move(mesh->radiosity), std::move(mesh->triangles)};
}

absl::StatusOr<BenchRender> BenchScene::render(std::uint32_t sample_begin, std::uint32_t sample_end,
                                               std::uint64_t seed_offset, std::stop_token stop) const {
  const std::chrono::nanoseconds start = base::thread_cpu_time();
  absl::StatusOr<BenchPhases> phases = make_phases(seed_offset, stop);
  if (!phases.ok()) return phases.status();
  BenchRender rendered;
  render::RenderStats stats;
  for (render::TileRequest tile : parts_->tiles) {
    tile.sample_begin = sample_begin, tile.sample_end = sample_end;
    tile.seed_offset = seed_offset;
    tile.prepared = phases->prepared.get();
    absl::StatusOr<wire::TileResult> result = parts_->scene->render_tile(tile, stop, stats);
    if (!result.ok()) return result.status();
    rendered.tiles.push_back(*std::move(result));
  }
  rendered.cost = cost_of(stats, base::in_seconds(base::thread_cpu_time() - start));
  return rendered;
}

std::size_t BenchScene::tile_count() const { return parts_->tiles.size(); }

absl::StatusOr<BenchRender> BenchScene::render_tile(std::size_t tile, std::uint32_t sample_begin,
                                                    std::uint32_t sample_end, const BenchPhases& phases,
                                                    std::stop_token stop) const {
  const std::chrono::nanoseconds start = base::thread_cpu_time();
  render::TileRequest request = parts_->tiles[tile];
  request.sample_begin = sample_begin, request.sample_end = sample_end;
  request.prepared = phases.prepared.get();
  render::RenderStats stats;
  BenchRender rendered;
  absl::StatusOr<wire::TileResult> result = parts_->scene->render_tile(request, stop, stats);
  if (!result.ok()) return result.status();
  rendered.tiles.push_back(*std::move(result));
  rendered.cost = cost_of(stats, base::in_seconds(base::thread_cpu_time() - start));
  return rendered;
}

std::map<std::string, double> BenchScene::structure() const {
  const render::RenderScene::Structure built = parts_->scene->structure();
  const render::StructureFigures& f = built.figures;
  std::map<std::string, double> figures{{"build_cpu_seconds", built.build_cpu_seconds},
                                        {"bytes", static_cast<double>(f.bytes)}};
  if (f.primitives == 0) return figures;
  figures.insert({{"primitives", static_cast<double>(f.primitives)},
                  {"nodes", static_cast<double>(f.nodes)},
                  {"leaves", static_cast<double>(f.leaves)},
                  {"empty_leaves", static_cast<double>(f.empty_leaves)},
                  {"references", static_cast<double>(f.references)},
                  {"depth", f.depth},
                  {"sah_cost", f.sah_cost}});
  return figures;
}

absl::StatusOr<BenchCeiling> BenchScene::measure_ceiling(std::uint32_t spp, std::stop_token stop) const {
  BenchCeiling total;
  const absl::StatusOr<BenchPhases> phases = make_phases(0, stop);
  if (!phases.ok()) return phases.status();
  for (render::TileRequest tile : parts_->tiles) {
    tile.sample_end = spp;
    tile.prepared = phases->prepared.get();
    const absl::StatusOr<render::RenderScene::Ceiling> ceiling = parts_->scene->measure_ceiling(tile, stop);
    if (!ceiling.ok()) return ceiling.status();
    total.render_cpu_seconds += ceiling->render_cpu_seconds;
    total.rays += ceiling->stats.rays();
    for (std::size_t kind = 0; kind < total.by_kind.size(); ++kind) {
      const auto& rays = ceiling->rays[kind];
      BenchRays& sum = total.by_kind[kind];
      sum.count += rays.count, sum.cpu_seconds += rays.cpu_seconds;
      sum.nodes += rays.visits.nodes, sum.primitives += rays.visits.primitives;
      total.replay_cpu_seconds += rays.cpu_seconds;
    }
  }
  return total;
}

/// The threads of render_in_turn, which take a tile of every scene at a time.
class BenchTurns {
 public:
  BenchTurns(std::span<const BenchScene* const> scenes, std::uint32_t spp, std::uint64_t seed_offset,
             std::stop_token stop)
      : scenes_(scenes),
        spp_(spp),
        seed_offset_(seed_offset),
        stop_(std::move(stop)),
        renders_(scenes.size()) {}

  absl::StatusOr<std::vector<BenchRender>> run(int threads) {
    for (std::size_t i = 0; i < scenes_.size(); ++i) {
      absl::StatusOr<BenchPhases> phases = scenes_[i]->make_phases(seed_offset_, stop_);
      if (!phases.ok()) return phases.status();
      renders_[i].cost += phases->cost;
      prepared_by_scene_.push_back(std::move(phases->prepared));
    }
    {
      std::vector<std::jthread> helpers;
      for (int i = 1; i < threads; ++i) helpers.emplace_back([this] { work(); });
      work();
    }
    if (!status_.ok()) return status_;
    return std::move(renders_);
  }

 private:
  void work() {
    std::size_t most = 0;
    for (const BenchScene* scene : scenes_) most = std::max(most, scene->parts_->tiles.size());
    for (std::size_t tile = next_++; tile < most; tile = next_++) {
      for (std::size_t i = 0; i < scenes_.size(); ++i) {
        const std::size_t scene = tile % 2 == 0 ? i : scenes_.size() - 1 - i;
        if (tile < scenes_[scene]->parts_->tiles.size() && !render(scene, tile)) return;
      }
    }
  }

  bool render(std::size_t scene, std::size_t index) {
    render::TileRequest tile = scenes_[scene]->parts_->tiles[index];
    tile.sample_end = spp_;
    tile.seed_offset = seed_offset_;
    tile.prepared = prepared_by_scene_[scene].get();
    render::RenderStats stats;
    const std::chrono::nanoseconds start = base::thread_cpu_time();
    absl::StatusOr<wire::TileResult> result = scenes_[scene]->parts_->scene->render_tile(tile, stop_, stats);
    const double seconds = base::in_seconds(base::thread_cpu_time() - start);

    const std::lock_guard lock{mutex_};
    if (!result.ok()) {
      status_ = result.status();
      next_ = SIZE_MAX / 2;  // the others stop at their next tile
      return false;
    }
    renders_[scene].tiles.push_back(*std::move(result));
    renders_[scene].cost += cost_of(stats, seconds);
    return true;
  }

  const std::span<const BenchScene* const> scenes_;
  const std::uint32_t spp_;
  const std::uint64_t seed_offset_;
  const std::stop_token stop_;
  std::vector<std::shared_ptr<const render::Prepared>> prepared_by_scene_;
  std::atomic<std::size_t> next_ = 0;
  std::mutex mutex_;
  std::vector<BenchRender> renders_;
  absl::Status status_;
};

absl::StatusOr<std::vector<BenchRender>> render_in_turn(std::span<const BenchScene* const> scenes,
                                                        std::uint32_t spp, std::uint64_t seed_offset,
                                                        int threads, std::stop_token stop) {
  return BenchTurns(scenes, spp, seed_offset, std::move(stop)).run(threads);
}

}  // namespace tessera::client
