// A client's calls to the coordinator of its own process: functions, no messages.
#pragma once

#include "farm/job_calls.h"

namespace tessera::server {
class Farm;
}

namespace tessera::client {

class LocalCalls final : public JobCalls {
 public:
  /// The farm must outlive the calls.
  explicit LocalCalls(server::Farm& farm) : farm_(farm) {}

  absl::StatusOr<std::string> submit(const v1::JobSpec& spec, const Reuse& reuse,
                                     std::stop_token stop) override;
  absl::StatusOr<v1::GetJobResponse> job(const std::string& job_id, std::stop_token stop) override;
  absl::StatusOr<std::vector<v1::JobStatus>> jobs(std::stop_token stop) override;
  absl::StatusOr<v1::JobStatus> cancel(const std::string& job_id, std::stop_token stop) override;
  /// Unavailable when the farm has stopped and `stop` is not requested within seconds.
  absl::StatusOr<v1::JobStatus> watch(const std::string& job_id, const WatchHandlers& handlers,
                                      std::stop_token stop) override;

 private:
  server::Farm& farm_;
};

}  // namespace tessera::client
