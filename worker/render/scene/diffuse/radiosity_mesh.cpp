#include "render/scene/diffuse/radiosity_mesh.h"

#include <algorithm>
#include <array>
#include <optional>

#include "render/scene/placement/render_space.h"
#include "wire/phases/radiosity_solution.h"

namespace tessera::render {

namespace {

using wire::Solution;
using wire::SolutionPatch;
using wire::SolutionVertex;

/// Appends the patches that a node falls into.
void collect(const Solution& solution, std::int32_t node, std::vector<const SolutionPatch*>& patches) {
  const std::int32_t value = solution.nodes[static_cast<std::size_t>(node)];
  if (value < 0) {
    patches.push_back(&solution.patches[static_cast<std::size_t>(-1 - value)]);
    return;
  }
  for (std::int32_t part = 0; part < 4; ++part) collect(solution, value + part, patches);
}

bool shines(const Solution& solution, const std::vector<const SolutionPatch*>& patches) {
  const auto is_lit = [&](std::uint32_t corner) {
    const SolutionVertex& vertex = solution.vertices[corner];
    return vertex.radiosity[0] > 0 || vertex.radiosity[1] > 0 || vertex.radiosity[2] > 0;
  };
  return std::any_of(patches.begin(), patches.end(), [&](const SolutionPatch* patch) {
    return std::any_of(std::begin(patch->corners), std::end(patch->corners), is_lit);
  });
}

/// Appends patches as triangles, whose corners go counterclockwise where they are seen from.
void add(const std::vector<const SolutionPatch*>& patches, bool turned, RadiosityMesh& mesh) {
  for (const SolutionPatch* patch : patches) {
    const auto& [a, b, c] = patch->corners;
    mesh.triangles.push_back(turned ? std::array{a, c, b} : std::array{a, b, c});
  }
}

}  // namespace

absl::StatusOr<RadiosityMesh> read_radiosity_mesh(const v1::Scene& scene, std::string_view blob) {
  const std::optional<Solution> solution = Solution::read(blob);
  if (!solution) return absl::InvalidArgumentError("the bytes are no solution of radiosity");
  const absl::StatusOr<Imath::V3d> origin = render_origin(scene);
  if (!origin.ok()) return origin.status();
  RadiosityMesh mesh;
  for (const SolutionVertex& vertex : solution->vertices) {
    std::array<float, 3> position, radiosity;
    for (std::size_t i = 0; i < 3; ++i) {
      position[i] = static_cast<float>(double{vertex.position[i]} + (*origin)[static_cast<int>(i)]);
      radiosity[i] = vertex.radiosity[i];
    }
    mesh.positions.push_back(position);
    mesh.radiosity.push_back(radiosity);
  }
  for (std::uint32_t side = 0; side + 1 < solution->sides; side += 2) {
    std::vector<const SolutionPatch*> front, back;
    collect(*solution, static_cast<std::int32_t>(side), front);
    collect(*solution, static_cast<std::int32_t>(side) + 1, back);
    const bool back_shines = shines(*solution, back);
    const bool turned = solution->turned[side / 2] != 0;
    if (!back_shines || shines(*solution, front)) add(front, turned, mesh);
    if (back_shines) add(back, !turned, mesh);
  }
  return mesh;
}

}  // namespace tessera::render
