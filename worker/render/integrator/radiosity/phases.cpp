#include "render/integrator/radiosity/phases.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "render/integrator/radiosity/memory.h"
#include "render/integrator/stage_timer.h"

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

/// Light before it is known: that of lamps.
Brightness lamps(const SceneTables& scene, const Surfaces& surfaces, const Clusters& clusters) {
  std::vector<Name> names;
  for (Side side = 0; side < surfaces.sides(); ++side) names.push_back(Name::of_side(side));
  Brightness result;
  for (const Matter& matter : matter_of(scene, surfaces, names)) {
    const float emitted = *std::max_element(std::begin(matter.emission.band), std::end(matter.emission.band));
    result.sides.push_back({emitted, emitted});
  }
  pull(surfaces, clusters, result);
  return result;
}

bool make_estimate(const IntegratorContext& context, const PartRequest& part, std::stop_token stop,
                   std::string& blob) {
  const Linked linked(context.scene);
  if (linked.clusters.empty())
    return make_links(context, part, stop, linked.surfaces, linked.clusters, {}, {}, blob);
  const Brightness brightness = lamps(context.scene, linked.surfaces, linked.clusters);
  const LinkBounds bounds{.split = false,
                          .error = kEstimateError * double{brightness.clusters.front().whole},
                          .factor = kEstimateFactor,
                          .rays = 2};
  return make_links(context, part, stop, linked.surfaces, linked.clusters, brightness, bounds, blob);
}

/// Links that a square unit may have, with what remains of the memory; those of a side, that it has anyhow,
/// apart.
double links_per_area(const Surfaces& surfaces, std::uint64_t memory_limit) {
  const std::uint64_t least = render::radiosity::least_memory(surfaces.sides());
  if (memory_limit <= least) return 1e-300;
  // Both sides of everything. A link's patch counts with it: there is at most one of these for a link.
  return static_cast<double>(memory_limit - least) / render::radiosity::kBytesPerLink /
         (2 * surfaces.whole_area());
}

bool make_final_links(const IntegratorContext& context, const PartRequest& part, std::stop_token stop,
                      std::string& blob) {
  const auto& before = *static_cast<const Linked*>(part.prepared);
  const RadiositySettings& settings = context.scene.radiosity;
  const LinkBounds bounds{.split = true,
                          .error = settings.error_bound * before.mean_irradiance,
                          .relative_error = std::sqrt(settings.error_bound),
                          .factor = kLargestFactor,
                          .smallest_area = settings.smallest_area > 0
                                               ? settings.smallest_area
                                               : kSmallestPatch * before.surfaces.whole_area(),
                          .links_per_area = links_per_area(before.surfaces, settings.memory_limit)};
  return make_links(context, part, stop, before.surfaces, before.clusters, before.brightness, bounds, blob);
}

bool merge_links(std::span<const std::string_view> blobs, std::string& merged) {
  Links links;
  for (const std::string_view blob : blobs) {
    if (!links.append(blob)) return false;
  }
  merged = links.blob();
  return true;
}

bool make_solution(const IntegratorContext& context, const PartRequest& part, std::stop_token,
                   std::string& blob) {
  const auto& linked = *static_cast<const Linked*>(part.prepared);
  const StageTimer timer(context.stats.times, Stage::kShading);
  std::optional<Forest> forest = Forest::grow(context.scene, linked.surfaces, linked.clusters, linked.links);
  if (!forest) return false;
  const Forest::Outcome outcome = forest->solve(context.scene.radiosity.residual);
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
  Links estimate;
  if (!estimate.append(blobs[0])) return nullptr;
  std::optional<Forest> forest = Forest::grow(scene, linked->surfaces, linked->clusters, estimate);
  if (!forest) return nullptr;
  if (blobs.size() == 2) return linked->links.append(blobs[1]) ? std::move(linked) : nullptr;
  forest->solve(scene.radiosity.residual);
  linked->brightness = forest->brightness();
  linked->mean_irradiance = forest->mean_irradiance();
  return linked;
}

}  // namespace

const AlgorithmPhase kPhases[3] = {
    {make_estimate, merge_links}, {make_final_links, merge_links}, {make_solution, merge_solutions}};

std::unique_ptr<const Prepared> prepare(const SceneTables& scene, std::span<const std::string_view> blobs) {
  if (blobs.size() < std::size(kPhases)) return prepare_links(scene, blobs);
  auto solved = std::make_unique<Solved>(scene);
  std::optional<Solution> solution = Solution::read(blobs.back());
  if (!solution || solution->sides != solved->surfaces.sides()) return nullptr;
  solved->solution = *std::move(solution);
  return solved;
}

}  // namespace tessera::render::TESSERA_ISA::radiosity
