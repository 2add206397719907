// Checks of jobs whose pixels take as many samples as their noise asks for.
#pragma once

#include "absl/status/status.h"
#include "tessera/v1/job.pb.h"

namespace tessera::wire {

/// OK when settings.noise is 0. InvalidArgument, by field, where it is out of range, or the cap, the tile
/// size or the samples of a unit do not go with it. Whether the algorithm does is in wire/algorithm.h.
absl::Status check_noise(const v1::JobSpec& spec);

}  // namespace tessera::wire
