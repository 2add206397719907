// Requests for leases, and what becomes of the answers.
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "agent/lease_table.h"

namespace tessera::agent {

/// Units are asked for with each result that is delivered, and by a call of their own when nothing is left to
/// do. Thread-safe.
class LeaseIntake {
 public:
  /// The part of a worker that keeps what it has loaded.
  struct Loaded {
    std::function<std::vector<std::string>()> scene_digests;
    /// Called when no unit of a job will come any more.
    std::function<void(const std::string& job_id)> forget_job;
  };

  /// Keeps `full` units queued in `leases`. `address`: the coordinator's, for messages.
  LeaseIntake(LeaseTable& leases, Loaded loaded, std::string address, std::size_t full);

  static constexpr std::size_t kKnownJobs =
      64;  // number of jobs whose specs are kept; one more, and the oldest is forgotten

  using Specs = std::map<std::string, std::shared_ptr<const v1::JobSpec>>;  // keys: job ids
  struct Ask {
    std::size_t units = 0;
    std::shared_ptr<const Specs> known_specs;  // the answer may leave them out; never null
    std::uint64_t deliveries = 0;              // LeaseTable::deliveries
  };

  /// Says in `request` how many units are wanted, which scenes are loaded and which jobs are known; nothing
  /// when none is wanted. Each Ask is to be answered.
  Ask ask(v1::LeaseRequest& request);

  /// `response` is null when the call brought none. Units that nobody asked for are taken, too.
  void answered(const Ask& ask, const v1::LeaseResponse* response);

 private:
  void take(const Ask& ask, const v1::LeaseResponse& response);
  std::shared_ptr<const Specs> known();
  /// Returns the jobs that are forgotten for these: the coordinator would not say of them that they are over.
  std::vector<std::string> know(const Specs& sent);
  void forget(const std::string& job_id);

  LeaseTable& leases_;
  const Loaded loaded_;
  const std::string address_;
  const std::size_t full_;
  std::mutex mutex_;
  std::shared_ptr<const Specs> recent_specs_ = std::make_shared<const Specs>();
  std::deque<std::string> recent_job_ids_;  // keys of recent_specs_, the oldest first
};

}  // namespace tessera::agent
