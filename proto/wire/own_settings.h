// Settings that only some algorithms have. Wishes name those of any algorithm, so that a scene may be
// rendered by several; a job has those of its own alone.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "tessera/v1/job.pb.h"

namespace tessera::wire {

/// Gives `algorithms` the settings of its integrator: what `wishes` say, and defaults where they say nothing.
void resolve_own_settings(const v1::RenderSettings& wishes, v1::Algorithms& algorithms);

/// InvalidArgument, naming the algorithms that have them, where `wishes` have settings that `integrator` has
/// not. The algorithm must exist.
absl::Status check_owner(const v1::RenderSettings& wishes, const std::string& integrator);

/// InvalidArgument where a job's algorithm, which must exist, lacks its settings or has those of another, or
/// where they are out of range.
absl::Status check_own_settings(const v1::Algorithms& algorithms);

}  // namespace tessera::wire
