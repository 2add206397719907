// What mutations of paths vertex by vertex cannot do.
#pragma once

#include "absl/status/status.h"
#include "render/integrator/scene_tables.h"

namespace tessera::render {

/// InvalidArgument, with the first obstacle, where the scene is to be rendered by Metropolis in path space
/// (MetropolisConfig::kind) and has something that only primary sample space can do.
absl::Status check_path_mutations(const SceneTables& tables);

}  // namespace tessera::render
