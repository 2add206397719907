// Jobs take their turns until they end.
#pragma once

#include <string>

#include "scheduler/farm_state.h"
#include "scheduler/policy/lease_book.h"

namespace tessera::server {

class JobCourse {
 public:
  JobCourse(FarmState& state, LeaseBook& book) : state_(state), book_(book) {}

  /// An open job takes its turns, unless it is paused.
  void take_turns(FarmJob& job);
  /// Its leases are over, and of what happened to its units only that is kept which a report of `state`
  /// needs.
  void end(FarmJob& job, v1::JobState state, std::string error);

 private:
  void leave_turns(const FarmJob& job);

  FarmState& state_;
  LeaseBook& book_;
};

}  // namespace tessera::server
