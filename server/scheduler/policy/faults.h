// Consequences where units are not rendered: who is at fault, the data or the host.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "scheduler/farm_state.h"
#include "scheduler/policy/eligibility.h"
#include "scheduler/policy/job_course.h"
#include "scheduler/policy/lease_book.h"
#include "scheduler/policy/trust.h"

namespace tessera::server {

class Faults {
 public:
  static constexpr std::uint32_t kRunPieces = 16;  // pieces into which a run is cut that was not rendered
  static constexpr Time kFirstBar{60'000};         // doubled each time
  static constexpr Time kLongestBar{3'600'000};

  Faults(FarmState& state, const Trust& trust, const Eligibility& eligibility, LeaseBook& book,
         JobCourse& course)
      : state_(state), trust_(trust), eligibility_(eligibility), book_(book), course_(course) {}

  /// The worker of this lease could not render its units (Scheduler::fail); the lease is over.
  void fail(FarmJob& job, LeaseId id, const FailureReport& report, Time now);
  /// Whether so many are gone at once that no unit is to blame.
  bool is_mass_loss(std::size_t workers) const;
  /// The worker of this lease was lost, and may have died of any of its units; the lease is over. Whether the
  /// job may be, too.
  bool blame_loss(LeaseId id, const WorkerInfo& worker, Time now);
  /// A worker that was thought dead has been heard of, with the unit still in its hands: the unit did not
  /// kill it.
  void absolve(FarmJob& job, const v1::LeaseToken& token, const std::string& host);
  /// The unit is not dangerous, or not any more.
  void forgive(FarmJob& job, std::uint32_t unit);
  /// Sets a unit aside that failed too often, and isolates one that may be what killed its workers.
  void judge_unit(FarmJob& job, std::uint32_t unit);
  /// The job goes on with a clean record, and what was set aside is to do again.
  void reopen(FarmJob& job);
  /// A unit of a phase is not given out any more: these hosts disagree on what it makes.
  void set_disputed_aside(FarmJob& job, std::uint32_t unit, const std::vector<std::string>& hosts,
                          const std::string& message);
  bool has_disputes(const FarmJob& job) const;
  /// Units of phases whose results are in what others failed to read, and that no two identities have made
  /// alike.
  std::set<std::uint32_t> doubted(const FarmJob& job) const;
  std::string what_is_missing(const FarmJob& job) const;
  /// A failure as it was journaled, or that it was none. Events of other kinds are none of these.
  void restore(FarmJob& job, const FarmEvent& event);

 private:
  void record_failure(const FarmJob& job, std::uint32_t unit, const UnitFailure& failure,
                      const std::vector<std::string>& log);
  void add_failure(FarmJob& job, std::uint32_t unit, UnitFailure failure, const std::vector<std::string>& log,
                   Time now);
  void cut_run(FarmJob& job, const UnitRun& units, const UnitFailure& failure,
               const std::vector<std::string>& log);
  static void shorten_runs(FarmJob& job, const UnitRun& units);
  void judge_scene(FarmJob& job, const std::string& message, Time now);
  void judge_host(FarmJob& job, std::uint32_t unit, const std::string& host, Time now);
  Time bar(FarmJob& job, const std::string& host, Time now);

  FarmState& state_;
  const Trust& trust_;
  const Eligibility& eligibility_;
  LeaseBook& book_;
  JobCourse& course_;
};

}  // namespace tessera::server
