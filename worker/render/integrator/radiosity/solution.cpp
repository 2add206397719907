#include "render/integrator/radiosity/solution.h"

#include <utility>

#include "render/integrator/radiosity/blob.h"

namespace tessera::render::radiosity {

namespace {

struct Numbers {
  std::uint64_t links, cut_short;
  std::uint32_t sweeps, sides;
  double residual;
};

bool is_consistent(const Solution& solution) {
  const auto patches = static_cast<std::int64_t>(solution.patches.size());
  const auto nodes = static_cast<std::int64_t>(solution.nodes.size());
  if (std::int64_t{solution.sides} > nodes) return false;
  for (std::int64_t i = 0; i < nodes; ++i) {
    const std::int64_t node = solution.nodes[static_cast<std::size_t>(i)];
    // Parts come after what they are parts of, so that every way down ends.
    if (node < 0 ? -node > patches : node <= i || node + 4 > nodes) return false;
  }
  for (const SolutionPatch& patch : solution.patches) {
    for (const std::uint32_t corner : patch.corners) {
      if (corner >= solution.vertices.size()) return false;
    }
  }
  return true;
}

}  // namespace

std::string Solution::blob() const {
  std::string blob;
  put_array(nodes, blob);
  put_array(patches, blob);
  put_array(vertices, blob);
  put_array(std::vector<Numbers>{{links, cut_short, sweeps, sides, residual}}, blob);
  return blob;
}

std::optional<Solution> Solution::read(std::string_view blob) {
  Solution solution;
  std::vector<Numbers> numbers;
  if (!take_array(blob, solution.nodes) || !take_array(blob, solution.patches) ||
      !take_array(blob, solution.vertices) || !take_array(blob, numbers) || numbers.size() != 1 ||
      !blob.empty())
    return std::nullopt;
  solution.links = numbers.front().links;
  solution.cut_short = numbers.front().cut_short;
  solution.sweeps = numbers.front().sweeps;
  solution.sides = numbers.front().sides;
  solution.residual = numbers.front().residual;
  return is_consistent(solution) ? std::optional(std::move(solution)) : std::nullopt;
}

}  // namespace tessera::render::radiosity
