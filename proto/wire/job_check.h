// Checks of jobs, alike in all three programs, and what follows from a job's algorithm.
#pragma once

#include "absl/status/status.h"
#include "tessera/v1/job.pb.h"

namespace tessera::wire {

/// InvalidArgument where the job's algorithm does not exist or cannot do what the job asks for.
absl::Status check_algorithm(const v1::JobSpec& spec);

/// Gives the job the phases of its algorithm, which must exist.
void add_phases(v1::JobSpec& spec);

/// Whether the job's units are passes. False for unknown algorithms.
bool works_in_passes(const v1::JobSpec& spec);

/// OK when settings.noise is 0. InvalidArgument, by field, where it is out of range, or the cap, the tile
/// size or the samples of a unit do not go with it. Whether the algorithm does is
/// check_algorithm()'s.
absl::Status check_noise(const v1::JobSpec& spec);

}  // namespace tessera::wire
