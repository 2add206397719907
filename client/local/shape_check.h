// Finds the shapes of a scene that workers would refuse, by the same code, before it is submitted.
#pragma once

#include <vector>

#include "import/import.h"

namespace tessera::client {

/// Faults of the scene's shapes, as many as an import tells of: for ImportOptions::find_faults.
std::vector<SceneFault> find_shape_faults(const ImportedScene& imported);

}  // namespace tessera::client
