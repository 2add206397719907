// Jobs whose ghosts of lights are found from the lights, too (RenderSettings.lens_ghosts).
#pragma once

#include "absl/status/status.h"
#include "tessera/v1/job.pb.h"

namespace tessera::wire {

/// InvalidArgument where light cannot be sent into the camera's lens in this job.
absl::Status allows_light_into_lens(const v1::JobSpec& spec);

}  // namespace tessera::wire
