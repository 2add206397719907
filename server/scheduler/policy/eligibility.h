// Who may have which unit.
#pragma once

#include <vector>

#include "scheduler/farm_state.h"
#include "scheduler/policy/classes.h"
#include "scheduler/policy/trust.h"

namespace tessera::server {

class Eligibility {
 public:
  Eligibility(const FarmState& state, const Trust& trust, const Classes& classes)
      : state_(state), trust_(trust), classes_(classes) {}

  /// Whether the worker may be given units of the job: trust, arithmetic, tags, bars and the job's limit.
  bool may_work_on(const FarmWorker& worker, const FarmJob& job, Time now) const;
  /// Whether the unit failed too often, but on one identity only, and another one could take it: one alone
  /// sets nothing aside.
  bool awaits_another(const FarmJob& job, const std::vector<UnitFailure>& failures) const;
  /// True when the unit failed on this host and another host could take it, or too often on this identity and
  /// another one could.
  bool avoids(const FarmWorker& worker, const FarmJob& job, std::uint32_t unit) const;

 private:
  const FarmState& state_;
  const Trust& trust_;
  const Classes& classes_;
};

}  // namespace tessera::server
