#include "render/build/view/path_mutations.h"

#include <algorithm>
#include <string>

#include "absl/strings/str_cat.h"
#include "render/integrator/mlt/path_space/limits.h"

namespace tessera::render {

namespace {

/// Its density is only an estimate, and acceptance needs the right one.
bool is_coated_conductor(const MaterialRecord& material) {
  return material.kind == BsdfKind::kCoatedConductor;
}

/// Empty where there is none.
std::string obstacle(const SceneTables& tables) {
  if (tables.max_depth > kMostEvents)
    return absl::StrCat("paths of at most ", kMostEvents, " events, and not of ", tables.max_depth);
  if (!sees_points(tables.camera)) return "a perspective or orthographic camera";
  if (tables.volumetric) return "a scene without media, and without surfaces that light passes straight";
  if (tables.lights.any_textures) return "lights without textures";
  if (tables.lights.infinite_lights.size() > 1) return "no more than one light from all around";
  if (std::ranges::any_of(tables.materials.materials, is_coated_conductor))
    return "materials other than coated conductors";
  return "";
}

}  // namespace

absl::Status check_path_mutations(const SceneTables& tables) {
  if (tables.metropolis.kind == MutationKind::kPrimary) return absl::OkStatus();
  const std::string needs = obstacle(tables);
  if (needs.empty()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("mutations in path space need ", needs, "; primary ones can do that"));
}

}  // namespace tessera::render
