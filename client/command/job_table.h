// Jobs and workers for people and for scripts.
#pragma once

#include <string>
#include <vector>

#include "google/protobuf/message.h"
#include "tessera/v1/farm.pb.h"

namespace tessera::client {

/// "running", "done" ...
const char* state_name(v1::JobState state);

/// The same with what else there is to say: paused, or how many units are missing.
std::string state_text(const v1::JobStatus& status);

/// One line a job under a heading.
std::string jobs_table(const std::vector<v1::JobStatus>& jobs);

/// One line a worker under a heading.
std::string workers_table(const std::vector<v1::WorkerStatus>& workers);

/// Everything about one job, a line each.
std::string job_text(const v1::GetJobResponse& job);

/// Protobuf's JSON mapping with the names of the .proto files, all fields present, on one line.
std::string to_json(const google::protobuf::Message& message);

}  // namespace tessera::client
