// Jobs from journals of all formats.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "tessera/v1/job.pb.h"

namespace tessera::server {

/// The spec of a journaled job, also of one that was written before a spec had parts (formats up to 4).
/// InvalidArgument for bytes that are neither.
absl::StatusOr<v1::JobSpec> read_spec(const std::string& bytes);

}  // namespace tessera::server
