// Costs of units, and paces of workers by comparison.
#pragma once

#include <string>

#include "scheduler/farm_state.h"
#include "scheduler/policy/classes.h"
#include "scheduler/policy/runs.h"

namespace tessera::server {

/// Nothing that a worker says of its costs is believed beyond what its lease lasted on the coordinator's
/// clock, nor beyond what the results of others bear out.
class Paces {
 public:
  // A result that comes so many times faster than those of others is doubtful.
  static constexpr double kDoubtful = 100;

  Paces(FarmState& state, Classes& classes) : state_(state), classes_(classes) {}

  /// Takes one finished lease into the averages of its job and the pace of its worker. Whether its result
  /// came doubtfully fast.
  bool measure(FarmJob& job, FarmWorker& worker, const Lease& lease, const DeliveredResult& result, Time now);

 private:
  void count_threads(FarmWorker& worker, const Lease& lease, double worked_ms, Time now);
  void compare_workers();

  FarmState& state_;
  Classes& classes_;
};

}  // namespace tessera::server
