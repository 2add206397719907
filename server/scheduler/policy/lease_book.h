// Leases, and the accounts of jobs and workers that follow from them.
#pragma once

#include <optional>
#include <string_view>

#include "scheduler/farm_state.h"
#include "scheduler/policy/runs.h"

namespace tessera::server {

class LeaseBook {
 public:
  static constexpr std::size_t kMaxHeartbeatsPerSecond = 2000;  // beyond it, the interval grows
  static constexpr Time kLongestHeartbeat{5000};

  LeaseBook(FarmState& state, const Runs& runs) : state_(state), runs_(runs) {}

  /// The units must be leased, or done where it is an audit.
  void add(FarmJob& job, FarmWorker& worker, Lease lease);
  /// Its units go back to pending when they are leased and this was their last lease.
  void drop(LeaseId id);
  /// The lease that the token names, which is this worker's.
  std::optional<LeaseId> find(const FarmJob& job, const v1::LeaseToken& token, std::string_view worker) const;
  /// The worker's lease of these units, whichever grant it names: after a restart a unit may be granted anew
  /// to the worker that has it in its hands, and the answer that says so may still be on its way.
  std::optional<LeaseId> find_own(const FarmJob& job, const UnitRun& units, std::string_view worker) const;

  Time heartbeat_interval() const;
  /// Two beats within it, one of which may be lost, are the least.
  Time lease_time() const;

 private:
  void index_only_lease(FarmJob& job, const UnitRun& units, bool add);

  FarmState& state_;
  const Runs& runs_;
};

}  // namespace tessera::server
