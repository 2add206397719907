// Jobs and workers for people and for scripts. What others have chosen, names above all, is escaped for
// terminals.
#pragma once

#include <string>
#include <vector>

#include "google/protobuf/message.h"
#include "tessera/v1/farm.pb.h"

namespace tessera::client {

/// "running", "done" ..., and "paused" for an open job that is.
std::string short_state(const v1::JobStatus& status);

/// The state with what else there is to say: paused, or how many units are missing.
std::string state_text(const v1::JobStatus& status);

/// One line a job under a heading; `width` as of Table::text.
std::string jobs_table(const std::vector<v1::JobStatus>& jobs, std::size_t width);

/// One line a worker under a heading, and below what is to be said of some.
std::string workers_table(const std::vector<v1::WorkerStatus>& workers, std::size_t width);

/// Everything about one job, a line each.
std::string job_text(const v1::GetJobResponse& job);

/// Protobuf's JSON mapping with the names of the .proto files, all fields present, on one line.
std::string to_json(const google::protobuf::Message& message);

}  // namespace tessera::client
