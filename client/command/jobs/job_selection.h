// Which jobs a command is about.
#pragma once

#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "command/command_line.h"
#include "farm/farm_client.h"

namespace tessera::client {

struct JobFilter {
  std::string user, state;  // empty: any
};

/// Defines --user and --state.
void define_job_filter(options::Command& command, JobFilter& filter);
bool matches(const JobFilter& filter, const v1::JobStatus& job);

struct JobSelection {
  std::vector<std::string> ids;  // ids, or unique beginnings of some
  bool all = false;
  JobFilter filter;
};

/// Defines ID..., --all, --user and --state.
void define_job_selection(options::Command& command, JobSelection& selection);

/// Tells which jobs a command is for, of those that --all, --user and --state find.
using Suits = std::function<bool(const v1::JobStatus&)>;

/// The ids of the jobs, each once. InvalidArgument where nothing is selected, both ways at once are used, or
/// a beginning is that of several jobs; NotFound where there is no such job. Otherwise the errors of
/// FarmClient::jobs.
absl::StatusOr<std::vector<std::string>> select_jobs(FarmClient& farm, const JobSelection& selection,
                                                     const Suits& suits, std::stop_token stop);

/// The id of the job that `id`, or its beginning, names. Errors as above.
absl::StatusOr<std::string> find_job_id(FarmClient& farm, const std::string& id, std::stop_token stop);

/// The same among these ids.
absl::StatusOr<std::string> find_job_id(const std::vector<std::string>& all, const std::string& id);

}  // namespace tessera::client
