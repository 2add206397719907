// From wishes to what holds.
#pragma once

#include "tessera/v1/job.pb.h"

namespace tessera::wire {

/// Sets the algorithms, the samples, and the view's sampler, seed, depth and layers to what `wishes` say, and
/// to the defaults where they say nothing: integrator "path", sampler "sobol", 16 samples a pixel, depth 5.
/// No path becomes longer than kMaxDepth. Samples go into several pixels only where that is asked for by
/// name: what is best depends on the scene's filter (wire/pixel_filter.h).
void resolve_settings(const v1::RenderSettings& wishes, v1::JobSpec& job);

}  // namespace tessera::wire
