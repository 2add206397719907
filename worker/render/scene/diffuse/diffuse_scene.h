// Scenes for algorithms that know diffuse triangles alone (AlgorithmTraits::diffuse_only).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "render/integrator/scene_tables.h"
#include "render/scene/view/settings.h"

namespace tessera::render {

/// Names for messages.
struct DiffuseSceneNames {
  const std::vector<std::string>& shapes;     // places in the scene of ShapeTable::shapes
  const std::vector<std::string>& materials;  // names of MaterialTable::materials
};

/// InvalidArgument where radiosity of so many triangles needs more memory than the limit.
absl::Status check_radiosity_memory(std::uint64_t triangles, std::uint64_t limit);

/// InvalidArgument names the first thing that is not diffuse or no triangle, or says what memory
/// the scene needs where that is more than it may have. With Settings::ignore_non_diffuse, materials become
/// diffuse by what they have of that, and a warning names each.
absl::Status make_diffuse(const Settings& settings, const DiffuseSceneNames& names, SceneArrays& arrays,
                          std::vector<std::string>& warnings);

}  // namespace tessera::render
