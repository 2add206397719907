#include "wire/phases/radiosity_solution.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "wire/phases/blob_arrays.h"
#include "wire/phases/phase_blob.h"

namespace tessera::wire {

namespace {

struct SolutionNumbers {
  std::uint64_t links, cut_short;
  std::uint32_t sweeps, sides;
  double residual;
};

/// Every node but the sides is the part of one other, which comes before it, and none is too deep.
bool is_forest(const Solution& solution) {
  constexpr std::uint8_t kNone = 255;
  const auto patches = static_cast<std::int64_t>(solution.patches.size());
  const std::size_t nodes = solution.nodes.size(), sides = solution.sides;
  if (sides > nodes) return false;
  std::vector<std::uint8_t> level(nodes, kNone);
  std::fill_n(level.begin(), sides, std::uint8_t{0});
  for (std::size_t i = 0; i < nodes; ++i) {
    const std::int64_t node = solution.nodes[i];
    if (level[i] == kNone) return false;
    if (node < 0 && -node <= patches) continue;
    const auto first = static_cast<std::size_t>(node);
    if (node < 0 || first <= i || first < sides || first + 4 > nodes || level[i] == PatchName::kDeepest)
      return false;
    for (std::size_t part = first; part < first + 4; ++part) {
      if (level[part] != kNone) return false;
      level[part] = static_cast<std::uint8_t>(level[i] + 1);
    }
  }
  return true;
}

template <std::size_t N>
bool are_finite(const float (&values)[N]) {
  return std::all_of(std::begin(values), std::end(values), [](float value) { return std::isfinite(value); });
}

bool is_consistent(const Solution& solution) {
  if (!is_forest(solution) || solution.sides != 2 * solution.turned.size()) return false;
  const auto is_patch = [&](const SolutionPatch& patch) {
    return are_finite(patch.irradiance) &&
           std::all_of(std::begin(patch.corners), std::end(patch.corners),
                       [&](std::uint32_t corner) { return corner < solution.vertices.size(); });
  };
  const auto is_vertex = [](const SolutionVertex& vertex) {
    return are_finite(vertex.position) && are_finite(vertex.irradiance) && are_finite(vertex.radiosity);
  };
  return std::ranges::all_of(solution.patches, is_patch) &&
         std::ranges::all_of(solution.vertices, is_vertex) &&
         std::ranges::all_of(solution.turned, [](std::uint8_t turned) { return turned <= 1; });
}

}  // namespace

std::string Solution::blob() const {
  std::string blob;
  put_array(nodes, blob);
  put_array(patches, blob);
  put_array(vertices, blob);
  put_array(turned, blob);
  put_array(std::vector<SolutionNumbers>{{links, cut_short, sweeps, sides, residual}}, blob);
  return blob;
}

std::optional<Solution> Solution::read(std::string_view blob) {
  Solution solution;
  std::vector<SolutionNumbers> numbers;
  if (!take_array(blob, solution.nodes) || !take_array(blob, solution.patches) ||
      !take_array(blob, solution.vertices) || !take_array(blob, solution.turned) ||
      !take_array(blob, numbers) || numbers.size() != 1 || !blob.empty())
    return std::nullopt;
  solution.links = numbers.front().links;
  solution.cut_short = numbers.front().cut_short;
  solution.sweeps = numbers.front().sweeps;
  solution.sides = numbers.front().sides;
  solution.residual = numbers.front().residual;
  return is_consistent(solution) ? std::optional(std::move(solution)) : std::nullopt;
}

const PhaseBlobCheck kRadiositySolutionCheck{[](const PhaseBlob& blob) { return blob.memory_limit; },
                                             [](std::string_view bytes, const PhaseBlob&) -> const char* {
                                               return Solution::read(bytes) ? nullptr
                                                                            : "no solution of radiosity";
                                             }};

}  // namespace tessera::wire
