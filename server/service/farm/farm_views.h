// The farm as those see it who look on.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "tessera/v1/farm.pb.h"

namespace tessera::server {

class BlobReader;
class FarmCore;
class WorkerRegistry;
struct JobEntry;
struct JobShape;

/// Some results of a job, and its status.
struct WatchBatch {
  v1::WatchJobResponse response;
  std::uint64_t last = 0;  // sequence number of the last result so far
  bool finished = false;   // the job is over and `last` was its last result
};

/// Pixels that a worker, named by its id, is rendering.
struct PixelsInWork {
  v1::PixelRect pixels;
  std::string worker;
};

/// Changes no job, but for results that turn out to be unreadable. NotFound for a job that is not there.
/// Thread-safe. The other parts must outlive it.
class FarmViews {
 public:
  FarmViews(FarmCore& core, const WorkerRegistry& workers) : core_(core), workers_(workers) {}

  v1::ListJobsResponse list_jobs() const;
  absl::StatusOr<v1::GetJobResponse> get_job(const std::string& id) const;
  /// Who submitted a job.
  absl::StatusOr<std::string> owner_of(const std::string& id) const;
  /// The job's shape, which follows from its spec.
  absl::StatusOr<std::shared_ptr<const JobShape>> shape_of(const std::string& id) const;

  v1::ListWorkersResponse list_workers() const;
  /// How often each worker is to be heard of, now.
  std::chrono::milliseconds heartbeat_interval() const;
  /// Pixels that the job's leases are about: `most` of them at most.
  std::vector<PixelsInWork> in_work(const std::string& id, std::size_t most) const;

  /// Returns what a watcher that has results up to `after` gets next; no results when there are none yet. A
  /// result that cannot be read is rendered again; DataLoss where it cannot be.
  absl::StatusOr<WatchBatch> next_results(const std::string& id, std::uint64_t after, bool status_only);
  /// The payload of one result, by its sequence number. DataLoss where it cannot be read any more.
  absl::StatusOr<std::string> result_of(const std::string& id, std::uint64_t sequence) const;
  /// Costs of the results `after + 1`, ..., `most` of them at most.
  absl::StatusOr<std::vector<v1::UnitStats>> costs_of(const std::string& id, std::uint64_t after,
                                                      std::uint32_t most) const;
  /// The blob that the job's last phase made. NotFound where there is none, or not yet, or not any more.
  absl::StatusOr<std::string> last_phase_of(const std::string& id) const;
  /// The job's scene, a serialized message. NotFound where it is not here any more.
  absl::StatusOr<std::unique_ptr<BlobReader>> scene_of(const std::string& id) const;

 private:
  struct Results;
  /// The job's state, for a watcher, and the results to be read for it.
  absl::StatusOr<Results> results_after(const std::string& id, std::uint64_t after, bool status_only) const;
  /// With the farm's lock held.
  v1::JobStatus describe(const JobEntry& entry) const;

  FarmCore& core_;
  const WorkerRegistry& workers_;
};

}  // namespace tessera::server
