// Jobs that a process before has begun in the same checkpoint.
#pragma once

#include <stop_token>
#include <string>

#include "absl/status/statusor.h"
#include "farm/job_calls.h"
#include "tessera/v1/job.pb.h"

namespace tessera::client {

/// The id of the job of `spec` in this process's own farm: the one that its checkpoint has, open or done, or
/// else a new one. Others that are open are given up: what they have may be taken over. Errors are those of
/// JobCalls.
absl::StatusOr<std::string> submit_or_go_on(JobCalls& calls, const v1::JobSpec& spec, std::stop_token stop);

}  // namespace tessera::client
