// Finds what workers would refuse of a scene, by the same code, before it is submitted.
#pragma once

#include <vector>

#include "import/import.h"
#include "tessera/v1/job.pb.h"

namespace tessera::client {

/// Faults of the scene's shapes, as many as an import tells of: for ImportOptions::find_faults.
std::vector<SceneFault> find_shape_faults(const ImportedScene& imported);

/// Things in the scene that the job's algorithm cannot do, as many as an import tells of; without any, the
/// fault of the camera, if it has one.
std::vector<SceneFault> find_job_faults(const v1::Scene& scene, const v1::JobSpec& job);

}  // namespace tessera::client
