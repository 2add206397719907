// From the settings that are asked for to those that hold.
#pragma once

#include "tessera/v1/job.pb.h"

namespace tessera::wire {

/// Sets the job's algorithms, view and samples to what `asked` say, and to what is usual (settings.proto)
/// where they say nothing: fields have the same names. No path becomes longer than kMaxDepth. Samples go into
/// several pixels, and pixels share light, only where that is asked for by name: what is best depends on the
/// scene (wire/pixel_filter.h) and on what else the job asks for.
void resolve_settings(const v1::RenderSettings& asked, v1::JobSpec& job);

/// Gives `algorithms` the settings that its integrator alone has: what `asked` say, and what is usual where
/// they say nothing.
void resolve_own_settings(const v1::RenderSettings& asked, v1::Algorithms& algorithms);

}  // namespace tessera::wire
