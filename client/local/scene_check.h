// Finds what workers would refuse of a scene, by the same code, before it is submitted.
#pragma once

#include <vector>

#include "import/import.h"
#include "tessera/v1/job.pb.h"

namespace tessera::client {

/// Faults of the scene's elements, as many as an import tells of. `job`: as of render::find_scene_faults().
std::vector<SceneFault> find_scene_faults(const ImportedScene& imported, const v1::JobSpec* job);

/// Things in the scene that the job cannot do, as many as an import tells of.
std::vector<SceneFault> find_job_faults(const ImportedScene& imported, const v1::JobSpec& job);

}  // namespace tessera::client
