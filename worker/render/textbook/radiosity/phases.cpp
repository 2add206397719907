#include "render/textbook/radiosity/phases.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "render/integrator/stage_timer.h"
#include "render/textbook/radiosity/memory.h"

namespace tessera::render::TESSERA_ISA::radiosity {

namespace {

// The estimate: of clusters that give a tenth of a point's light at most, and lamps as exactly as a tenth of
// the light that would be everywhere if the surfaces took all of it.
constexpr double kEstimateFactor = 0.1;
constexpr double kEstimateError = 0.1;
/// Clusters of the final links.
constexpr double kLargestFactor = 0.1;
/// A patch of this share of the scene's surface is small, unless the job says otherwise.
constexpr double kSmallestPatch = 2e-5;

/// The sides of one part, so that areas and numbers of sides together are about the same in all.
std::pair<Side, Side> sides_of(const Surfaces& surfaces, const PartRequest& part) {
  const auto share = [&](std::uint32_t p) { return double(p) / part.parts; };
  const double each = surfaces.whole_area() / std::max<double>(surfaces.sides(), 1);
  double before = 0;
  const double all = 3 * surfaces.whole_area();
  Side begin = surfaces.sides(), end = surfaces.sides();
  for (Side side = 0; side < surfaces.sides(); ++side) {
    // In the middle of its own share.
    const double own = surfaces.area(side) + each, at = (before + own / 2) / all;
    if (at >= share(part.part)) begin = std::min(begin, side);
    if (at >= share(part.part + 1)) end = std::min(end, side);
    before += own;
  }
  if (part.part == 0) begin = 0;
  if (part.part + 1 == part.parts) end = surfaces.sides();
  return {std::min(begin, end), end};
}

/// Links all sides of a part. False when stopped.
bool make_links(const IntegratorContext& context, const PartRequest& part, std::stop_token stop,
                const Surfaces& surfaces, const Clusters& clusters, const Brightness& brightness,
                const LinkBounds& bounds, std::string& blob) {
  Links links;
  const auto linker = std::make_unique<Linker>(context, surfaces, clusters, brightness, bounds);
  const auto [begin, end] = sides_of(surfaces, part);
  for (Side side = begin; side < end; ++side) {
    if (stop.stop_requested()) return false;
    linker->link(side, links);
  }
  blob = links.blob();
  return true;
}

/// Data that parts of the estimate read: patches, and light before it is known, that of lamps.
struct Lamps {
  explicit Lamps(const SceneTables& scene) : surfaces(scene.shapes), clusters(surfaces) {
    std::vector<Name> names;
    for (Side side = 0; side < surfaces.sides(); ++side) names.push_back(Name::of_side(side));
    for (const Matter& matter : matter_of(scene, surfaces, names)) {
      const float emitted =
          *std::max_element(std::begin(matter.emission.band), std::end(matter.emission.band));
      brightness.sides.push_back({emitted, emitted});
    }
    pull(surfaces, clusters, brightness);
  }

  const Surfaces surfaces;
  const Clusters clusters;
  Brightness brightness;
};

/// The same for all threads that need it at once: with one each, memory would grow with their number.
std::shared_ptr<const Lamps> shared_lamps(const SceneTables& scene) {
  static std::mutex mutex;
  static std::map<const SceneTables*, std::weak_ptr<const Lamps>> known;
  const std::lock_guard lock(mutex);
  std::erase_if(known, [](const auto& entry) { return entry.second.expired(); });
  if (const auto found = known.find(&scene); found != known.end()) {
    if (std::shared_ptr<const Lamps> lamps = found->second.lock()) return lamps;
  }
  auto lamps = std::make_shared<const Lamps>(scene);
  known[&scene] = lamps;
  return lamps;
}

/// Bytes that there are for links besides those that sides have anyhow.
double spare_bytes(const Surfaces& surfaces, std::uint64_t memory_limit) {
  const std::uint64_t least = render::radiosity::least_memory(surfaces.sides());
  return memory_limit > least ? static_cast<double>(memory_limit - least) : 0;
}

bool make_estimate(const IntegratorContext& context, const PartRequest& part, std::stop_token stop,
                   std::string& blob) {
  const std::shared_ptr<const Lamps> lamps = shared_lamps(context.scene);
  if (lamps->clusters.empty())
    return make_links(context, part, stop, lamps->surfaces, lamps->clusters, {}, {}, blob);
  // Links between whole sides are as many on small ones as on large ones.
  const double bytes_per_side =
      render::radiosity::kLeastLinks * render::radiosity::kBytesPerLink +
      spare_bytes(lamps->surfaces, context.scene.radiosity.memory_limit) / lamps->surfaces.sides();
  const LinkBounds bounds{.split = false,
                          .error = kEstimateError * double{lamps->brightness.clusters.front().whole},
                          .factor = kEstimateFactor,
                          .rays = 2,
                          .links_per_side = bytes_per_side / render::radiosity::kBytesPerEstimateLink};
  return make_links(context, part, stop, lamps->surfaces, lamps->clusters, lamps->brightness, bounds, blob);
}

bool make_final_links(const IntegratorContext& context, const PartRequest& part, std::stop_token stop,
                      std::string& blob) {
  const auto& before = *static_cast<const Linked*>(part.prepared);
  const RadiositySettings& settings = context.scene.radiosity;
  {
    const StageTimer timer(context.stats.times, Stage::kShading);
    if (!before.estimate->finish(settings.residual, stop)) return false;
  }
  const Estimate& estimate = *before.estimate;
  // Both sides of everything. A link's patch counts with it: there is at most one of these for a link.
  const double links = spare_bytes(before.surfaces, settings.memory_limit) / render::radiosity::kBytesPerLink;
  const LinkBounds bounds{.split = true,
                          .error = settings.error_bound * estimate.mean_irradiance(),
                          .relative_error = std::sqrt(settings.error_bound),
                          .factor = kLargestFactor,
                          .smallest_area = settings.smallest_area > 0
                                               ? settings.smallest_area
                                               : kSmallestPatch * before.surfaces.whole_area(),
                          .links_per_side = render::radiosity::kLeastLinks,
                          .links_per_area = links / (2 * before.surfaces.whole_area())};
  return make_links(context, part, stop, before.surfaces, before.clusters, estimate.brightness(), bounds,
                    blob);
}

bool merge_all_links(std::span<const std::string_view> blobs, std::string& merged) {
  std::optional<std::string> all = wire::merge_links(blobs);
  if (!all) return false;
  merged = *std::move(all);
  return true;
}

bool make_solution(const IntegratorContext& context, const PartRequest& part, std::stop_token stop,
                   std::string& blob) {
  const auto& linked = *static_cast<const Linked*>(part.prepared);
  const StageTimer timer(context.stats.times, Stage::kShading);
  std::optional<Forest> forest = Forest::grow(context.scene, linked.surfaces, linked.clusters, linked.links);
  if (!forest) return false;
  const double residual = context.scene.radiosity.residual;
  while (!forest->advance(residual)) {
    if (stop.stop_requested()) return false;
  }
  const Forest::Outcome& outcome = forest->outcome();
  Solution solution = show(context.scene.shapes, linked.surfaces, *forest);
  solution.links = linked.links.links.size();
  solution.cut_short = linked.links.cut_short;
  solution.sweeps = static_cast<std::uint32_t>(outcome.sweeps);
  solution.residual = outcome.residual;
  if (solution.cut_short > 0) {
    context.stats.warnings.push_back("radiosity: " + std::to_string(solution.cut_short) +
                                     " sides of triangles have coarser links than the error bound asks for: "
                                     "memory_limit has no room for more");
  }
  if (!(outcome.residual <= residual)) {
    context.stats.warnings.push_back("radiosity: after " + std::to_string(outcome.sweeps) +
                                     " sweeps the solution still moves " + std::to_string(outcome.residual) +
                                     " of all light a sweep, more than the residual: some surfaces reflect "
                                     "nearly all light");
  }
  blob = solution.blob();
  return true;
}

bool merge_solutions(std::span<const std::string_view> blobs, std::string& merged) {
  if (blobs.size() != 1) return false;
  merged = blobs.front();
  return true;
}

std::unique_ptr<const Prepared> prepare_links(const SceneTables& scene,
                                              std::span<const std::string_view> blobs) {
  auto linked = std::make_unique<Linked>(scene);
  Links links;
  if (!links.append(blobs.back())) return nullptr;
  if (blobs.size() == 2) {
    if (!are_sound(links, linked->surfaces, linked->clusters, Name::kDeepest)) return nullptr;
    linked->links = std::move(links);
    return linked;
  }
  std::optional<Forest> forest = Forest::grow(scene, linked->surfaces, linked->clusters, links, 0);
  if (!forest) return nullptr;
  linked->estimate = std::make_unique<Estimate>(*std::move(forest));
  return linked;
}

}  // namespace

bool Estimate::finish(double residual, std::stop_token stop) {
  for (;;) {
    const std::lock_guard lock(mutex_);
    if (!forest_) return true;
    if (stop.stop_requested()) return false;
    if (!forest_->advance(residual)) continue;
    brightness_ = forest_->brightness();
    mean_irradiance_ = forest_->mean_irradiance();
    forest_.reset();
  }
}

const AlgorithmPhase kPhases[3] = {
    {make_estimate, merge_all_links}, {make_final_links, merge_all_links}, {make_solution, merge_solutions}};

std::unique_ptr<const Prepared> prepare(const SceneTables& scene, std::span<const std::string_view> blobs) {
  if (blobs.size() < std::size(kPhases)) return prepare_links(scene, blobs);
  auto solved = std::make_unique<Solved>(scene);
  std::optional<Solution> solution = Solution::read(blobs.back());
  if (!solution || solution->sides != solved->surfaces.sides()) return nullptr;
  solved->solution = *std::move(solution);
  return solved;
}

}  // namespace tessera::render::TESSERA_ISA::radiosity
