// The leases that are out, found by unit, by worker, and by deadline.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <queue>
#include <string>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "scheduler/unit_run.h"

namespace tessera::server {

/// Monotonic time since some fixed instant.
using Time = std::chrono::milliseconds;

using LeaseId = std::uint64_t;

/// One grant of one unit, or of a run of them, to one worker.
struct Lease {
  std::uint64_t job = 0;  // number of the job
  UnitRun units;
  std::uint32_t attempt = 0;  // unique within the job, together with `epoch`
  std::uint64_t epoch = 0;    // epoch of the coordinator that granted it
  std::string worker;
  Time granted_at{};
  Time deadline{};
  bool audit = false;      // the units are done; this is a second opinion
  std::uint32_t spot = 0;  // number of the one spot of the units that is rendered (spot.h); 0: all of them
  double work_share = 1;   // part of the units' work that is leased
  std::int64_t charge_ms = 0;  // work as expected when it was granted; for fair shares
  Time expected_end{};         // time when its result ought to come, from what is known of job and worker
};

class LeaseTable {
 public:
  LeaseId add(Lease lease);
  /// The lease as it was.
  Lease remove(LeaseId id);
  /// Moves the deadline; only ever later.
  void refresh(LeaseId id, Time deadline);

  bool contains(LeaseId id) const { return leases_.contains(id); }
  const Lease& get(LeaseId id) const { return leases_.at(id); }
  std::size_t size() const { return leases_.size(); }

  /// Leases that have the unit, oldest first.
  std::vector<LeaseId> of_unit(std::uint64_t job, std::uint32_t unit) const;
  std::vector<LeaseId> of_worker(const std::string& worker) const;
  std::size_t count_of_worker(const std::string& worker) const;
  /// Looks at every lease; for events that are rare.
  std::vector<LeaseId> of_job(std::uint64_t job) const;

  /// A lease whose deadline is not after `now`, to be removed by the caller; none when there is none.
  std::optional<LeaseId> expired(Time now);

 private:
  using UnitKey = std::pair<std::uint64_t, std::uint32_t>;  // job, unit

  LeaseId next_id_ = 1;
  absl::flat_hash_map<LeaseId, Lease> leases_;
  absl::flat_hash_map<UnitKey, std::vector<LeaseId>> by_unit_;
  absl::flat_hash_map<std::string, absl::flat_hash_set<LeaseId>> by_worker_;
  // Deadlines as they were when pushed: an entry that comes up is checked, and pushed again if the lease was
  // refreshed.
  using Deadline = std::pair<Time, LeaseId>;
  std::priority_queue<Deadline, std::vector<Deadline>, std::greater<>> deadlines_;
};

}  // namespace tessera::server
