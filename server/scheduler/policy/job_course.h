// Jobs take their turns until they end.
#pragma once

#include <string>
#include <vector>

#include "scheduler/farm_state.h"
#include "scheduler/policy/lease_book.h"

namespace tessera::server {

class JobCourse {
 public:
  JobCourse(FarmState& state, LeaseBook& book) : state_(state), book_(book) {}

  /// An open job takes its turns, unless it is paused or other jobs have to be done first.
  void take_turns(FarmJob& job);
  /// A new job waits for those of JobRequest::after that are neither done nor forgotten.
  void await_others(FarmJob& job);
  /// Its leases are over, and of what happened to its units only that is kept which a report of `state`
  /// needs. Jobs that await it begin when it is done, and fail when it failed or was cancelled; those that
  /// await these fail too. One that is incomplete may still be done (Scheduler::retry_job).
  void end(FarmJob& job, v1::JobState state, std::string error);
  /// The job will never be done: those that await it fail, for `why` ("was deleted").
  void fail_awaiting(const std::string& job, const std::string& why);

 private:
  void end_alone(FarmJob& job, v1::JobState state, std::string error);
  /// Open jobs that await this one, which they do no longer.
  std::vector<FarmJob*> take_awaiting(const std::string& job);
  void leave_turns(const FarmJob& job);

  FarmState& state_;
  LeaseBook& book_;
};

}  // namespace tessera::server
