// Light of a scene that an algorithm never finds, whatever the number of samples.
#pragma once

#include <string>
#include <vector>

#include "render/integrator/scene_tables.h"
#include "tessera/v1/scene.pb.h"
#include "wire/algorithm.h"

namespace tessera::render {

/// Returns a warning that names what the algorithm is blind to (wire::Blindness) in this scene, by which
/// light and which material, and the algorithms that see it; empty where it sees all light. Materials that no
/// shape has do not count. `material_names` are those of tables.materials.
std::string unseen_light(const wire::AlgorithmTraits& algorithm, const SceneTables& tables,
                         const v1::Scene& scene, const std::vector<std::string>& material_names);

}  // namespace tessera::render
