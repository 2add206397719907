// Costs of units, and paces of workers by comparison.
#pragma once

#include "scheduler/farm_state.h"

namespace tessera::server {

class Paces {
 public:
  explicit Paces(FarmState& state) : state_(state) {}

  /// Takes one finished lease into the averages of its job and the pace of its worker.
  void measure(FarmJob& job, FarmWorker& worker, const Lease& lease, const DeliveredResult& result, Time now);

 private:
  void compare_workers();

  FarmState& state_;
};

}  // namespace tessera::server
