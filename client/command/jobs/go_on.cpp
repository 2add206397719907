#include "command/jobs/go_on.h"

#include "wire/version.h"

namespace tessera::client {
namespace {

/// The job of the checkpoint that is the same, and open or done; empty when there is none.
absl::StatusOr<std::string> find_job_to_go_on(JobCalls& client, v1::JobSpec spec, std::stop_token stop) {
  spec.mutable_content()->set_build(wire::build_version());
  const auto jobs = client.jobs(stop);
  if (!jobs.ok()) return jobs.status();
  std::string found;
  for (const v1::JobStatus& status : *jobs) {
    if (has_ended(status.state()) && status.state() != v1::DONE) continue;
    const auto job = client.job(status.job_id(), stop);
    if (!job.ok()) return job.status();
    if (job->spec().SerializeAsString() == spec.SerializeAsString()) {
      found = status.job_id();
    } else if (has_ended(status.state())) {
      continue;
    } else if (const auto cancelled = client.cancel(status.job_id(), stop); !cancelled.ok()) {
      return cancelled.status();
    }
  }
  return found;
}

}  // namespace

absl::StatusOr<std::string> submit_or_go_on(JobCalls& calls, const v1::JobSpec& spec, std::stop_token stop) {
  absl::StatusOr<std::string> job_id = find_job_to_go_on(calls, spec, stop);
  if (job_id.ok() && job_id->empty()) job_id = calls.submit(spec, {}, stop);
  return job_id;
}

}  // namespace tessera::client
