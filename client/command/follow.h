// Waits for a job and puts its image together.
#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "farm/farm_client.h"
#include "image/assemble.h"
#include "image/image.h"

namespace tessera::client {

struct FollowedJob {
  v1::JobStatus status;
  std::optional<Image> image;  // when the job is done, or incomplete
  std::uint64_t incomplete_pixels = 0;
  std::vector<Hole> holes;
  double wall_seconds = 0;  // of following
};

/// Follows the job to its end, with progress on stderr unless `quiet`. Errors: those of FarmClient::watch; Internal
/// when results do not fit the job.
absl::StatusOr<FollowedJob> follow_job(FarmClient& farm, const std::string& job_id, const v1::JobSpec& spec, bool quiet,
                                       std::stop_token stop);

/// The same without an image: progress only.
absl::StatusOr<v1::JobStatus> follow_progress(FarmClient& farm, const std::string& job_id, const v1::JobSpec& spec,
                                              std::stop_token stop);

/// The exit code of a job that has ended, with a message on stderr when that was not well: of an incomplete one, kHoles
/// and what is missing.
int report_end(const v1::JobStatus& status);

/// What ends a command that followed a job: lists holes in the image's attribute "tessera.holes", prints the job's
/// warnings (unless quiet) and its error, writes the image with its metadata to `output`, and returns the exit code.
int deliver(FollowedJob& followed, const v1::JobSpec& spec, const std::string& output, bool half, bool quiet);

}  // namespace tessera::client
