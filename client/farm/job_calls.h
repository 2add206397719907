// The calls by which a client has a job rendered, wherever the coordinator is.
#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "tessera/v1/farm.pb.h"

namespace tessera::client {

/// All calls end with Cancelled when `stop` is requested. Not thread-safe.
class JobCalls {
 public:
  virtual ~JobCalls() = default;

  /// Whose results a new job takes over.
  struct Reuse {
    std::string continued;  // this job's; empty: those of whichever job has most of them
    bool fresh = false;     // nobody's
    // The submission's own id: a user who gives one for the second time is answered with the job of the first
    // time, as long as that job is kept. Empty: a new one.
    std::string request_id = {};
  };
  /// Returns the job's id. FailedPrecondition when blobs are missing, or the job is not one to continue with
  /// this spec; NotFound when there is none.
  virtual absl::StatusOr<std::string> submit(const v1::JobSpec& spec, const Reuse& reuse,
                                             std::stop_token stop) = 0;

  virtual absl::StatusOr<v1::GetJobResponse> job(const std::string& job_id, std::stop_token stop) = 0;
  virtual absl::StatusOr<std::vector<v1::JobStatus>> jobs(std::stop_token stop) = 0;
  virtual absl::StatusOr<v1::JobStatus> cancel(const std::string& job_id, std::stop_token stop) = 0;

  struct WatchHandlers {
    // Every result once, in the order of its journal. An error ends the watch. Absent: results are not sent.
    std::function<absl::Status(const v1::UnitResult&)> result;
    std::function<void(const v1::JobStatus&)> status;
    // Results that were given before turned out to be wrong: forget all of them, they come again from the
    // first one on.
    std::function<absl::Status()> restart;
  };
  /// Follows the job to its end, and returns the final status.
  virtual absl::StatusOr<v1::JobStatus> watch(const std::string& job_id, const WatchHandlers& handlers,
                                              std::stop_token stop) = 0;
};

/// State of one watch, over all breaks of its connection.
struct WatchProgress {
  std::uint64_t after = 0;  // the last result handled
  v1::JobStatus last;
  bool restarted = false;  // results turned out to be wrong: again from the first one
  absl::Status handler_status;

  /// Hands on what came. False when the watch is to be begun anew after `after`, or a handler has failed.
  bool take(v1::WatchJobResponse& response, const JobCalls::WatchHandlers& handlers);
};

/// 128 random bits in hexadecimal: the request_id of a submission.
std::string make_request_id();

/// True for DONE, INCOMPLETE, FAILED and CANCELLED.
bool has_ended(v1::JobState state);

}  // namespace tessera::client
