// Who gets which unit, for how long.
#pragma once

#include "scheduler/farm_state.h"
#include "scheduler/policy/audits.h"
#include "scheduler/policy/checks.h"
#include "scheduler/policy/classes.h"
#include "scheduler/policy/eligibility.h"
#include "scheduler/policy/lease_book.h"
#include "scheduler/policy/runs.h"
#include "scheduler/policy/steps.h"
#include "scheduler/policy/trust.h"

namespace tessera::server {

class Leasing {
 public:
  static constexpr std::int64_t kAffinitySlackMs = 4000;

  Leasing(FarmState& state, const Trust& trust, Classes& classes, const Eligibility& eligibility,
          const Runs& runs, LeaseBook& book, const Audits& audits, const Checks& checks)
      : state_(state),
        trust_(trust),
        classes_(classes),
        eligibility_(eligibility),
        runs_(runs),
        book_(book),
        audits_(audits),
        checks_(checks) {}

  /// Scheduler::lease. The time of turns is `now` already.
  LeaseDecision lease(FarmWorker& worker, const LeaseRequest& request, Time now);
  /// A lease that is not known any more goes on where it was, when nobody else has begun with its units.
  bool take_up(FarmWorker& worker, FarmJob& job, const UnitRun& units, const v1::LeaseToken& token, Time now);

 private:
  struct Batch;  // the leases of one call of lease()
  bool has_units_for(const Batch& batch, const FarmJob& job) const;
  FarmJob* choose_job(Batch& batch);
  bool lease_pending(Batch& batch);
  bool lease_copy(Batch& batch);
  bool lease_audit(Batch& batch);
  bool lease_spot(Batch& batch);
  bool lease_dangerous(Batch& batch);
  bool has_room(const Batch& batch, const FarmJob& job) const;
  bool is_left(const Batch& batch, std::int32_t priority, std::uint64_t wanted) const;
  bool would_come_late(const Batch& batch, const FarmJob& job) const;
  /// `spot`: that of an audit, where it is not of the whole.
  void grant(Batch& batch, FarmJob& job, const UnitRun& units, bool audit, const Spot& spot = {});

  FarmState& state_;
  const Trust& trust_;
  Classes& classes_;
  const Eligibility& eligibility_;
  const Runs& runs_;
  LeaseBook& book_;
  const Audits& audits_;
  const Checks& checks_;
};

}  // namespace tessera::server
