// Every job that the coordinator knows, as clients see it: spec, results in order, cost.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/status/statusor.h"
#include "scheduler/scheduler.h"
#include "service/job/completion_rate.h"
#include "service/job/host_shares.h"
#include "service/job/phase_blobs.h"
#include "service/job/user_blobs.h"
#include "store/journal.h"
#include "tessera/v1/job.pb.h"
#include "wire/tile_result.h"

namespace tessera::server {

/// Everything that follows from a spec alone, shared with calls that work on it without the farm's lock.
struct JobShape {
  v1::JobSpec spec;
  std::shared_ptr<const WorkPlan> plan;
  std::vector<wire::ChannelDesc> channels;
  std::string key;  // result_key()
  std::size_t spec_bytes = 0;

  /// InvalidArgument for a spec that is unsound.
  static absl::StatusOr<std::shared_ptr<const JobShape>> make(v1::JobSpec spec);
};

struct JobEntry {
  std::string id;
  std::string request_id;  // request_key()
  std::shared_ptr<const JobShape> shape;
  std::uint32_t generation = 1;
  std::int64_t submitted_unix_ms = 0;
  std::int64_t finished_unix_ms = 0;
  std::uint64_t uploaded_bytes = 0;

  /// Set for a job that ended a while ago, or before this coordinator started: the scheduler does not know
  /// it.
  std::optional<JobView> past;

  v1::UnitStats stats;
  HostShares hosts;
  /// Units of each result, by sequence number - 1; the first is kRevoked where the result does not count any
  /// more. Empty when `past` is set: the journal knows.
  std::vector<CoveredUnits> units_by_sequence;
  static constexpr std::uint32_t kRevoked = ~std::uint32_t{0};
  /// Where `past` is set: numbers of results that do not count, ascending.
  std::vector<std::uint64_t> past_revoked;
  /// Blobs of the phases' units, while the scheduler knows the job; then the phases' own alone.
  PhaseBlobs phase_blobs = {};
  std::uint64_t result_bytes = 0;
  bool fetched = false;  // a client has all results
  /// Results that are on disk; clients see only those.
  std::uint64_t durable_results = 0;
  std::uint64_t durable_units = 0;     // units that these cover
  std::uint32_t bounds_under_way = 0;  // choices of an arithmetic class that are not on disk yet
  /// The job is over, and that is on disk.
  bool durable_end = false;
  std::uint32_t times_reopened = 0;

  // For people who wait; since the coordinator started.
  static constexpr std::size_t kLatestFailures = 16, kNotedFailures = 64;
  std::uint64_t units = 0;  // units that results brought
  CompletionRate rate = {};
  std::uint64_t failures = 0;
  /// A failure with the worker's log.
  struct NotedFailure {
    v1::FailedUnit failed;
    std::int64_t grant = 0;  // UnitFailure::grant; 0: of a run
  };
  std::deque<NotedFailure> noted_failures = {};  // oldest first
};

/// Returns the key by which a submission that is sent twice is known: clients choose their ids, and each user
/// has a space of their own.
std::string request_key(const std::string& user, const std::string& request_id);

/// A result is there, which counts.
void add_result(JobEntry& entry, const CoveredUnits& units, const std::string& host,
                const v1::UnitStats& stats);

/// So many results are on disk.
void note_durable(JobEntry& entry, std::uint64_t results);

/// Request by which the scheduler knows a job.
JobRequest request_of(const JobEntry& entry);

class JobTable {
 public:
  /// The job's blobs have these sizes, in the order of its spec.
  JobEntry& add(JobEntry entry, const std::vector<std::uint64_t>& blob_sizes);
  JobEntry* find(const std::string& id);
  JobEntry* find_request(const std::string& request_key);
  void erase(const std::string& id);
  /// Returns the jobs in order of submission.
  const std::vector<std::unique_ptr<JobEntry>>& all() const { return entries_; }
  /// The blobs that these jobs name.
  const UserBlobs& blobs() const { return blobs_; }

 private:
  std::vector<std::unique_ptr<JobEntry>> entries_;
  absl::flat_hash_map<std::string, JobEntry*> by_id_;
  absl::flat_hash_map<std::string, JobEntry*> by_request_;
  UserBlobs blobs_;
};

/// The scheduler need not know the job any more: nothing is kept of it that grows with its units.
void retire(JobEntry& entry, JobView view);
/// The opposite, from what the journal has of the job, which is to go on.
void recall(JobEntry& entry, const JobRecord& record);

/// Job as the journal holds it. DataLoss when its spec cannot be read any more.
absl::StatusOr<JobEntry> entry_of(const JobRecord& record);

v1::JobStatus status_of(const JobEntry& entry, const JobView& view);

/// Puts the workers' logs to the failures of `status`, which is that of `entry` and `view`.
void add_failure_logs(const JobEntry& entry, const JobView& view, v1::JobStatus& status);

inline bool is_open(v1::JobState state) { return state == v1::QUEUED || state == v1::RUNNING; }

/// Time that a worker took for a unit.
std::chrono::nanoseconds time_of(const v1::UnitStats& unit);

/// Cost of the results until now, to be journaled behind them.
JobStats stats_of(const JobEntry& entry);

/// Adds the cost of one unit. Warnings and notes that are new are kept, up to a
/// bound.
void add_stats(v1::UnitStats& total, const v1::UnitStats& unit);

/// Cuts what one program could flood another with: number and length of warnings and notes.
v1::UnitStats bounded(v1::UnitStats stats);

/// The same, as far as a lease of that duration can have cost so much on so many threads.
v1::UnitStats bounded_by(v1::UnitStats stats, std::chrono::milliseconds lasted, std::uint32_t threads);

}  // namespace tessera::server
