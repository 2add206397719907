// The farm's state machine: jobs, units, leases and workers. Pure: no clock, no I/O, no threads. Time and
// events come in, decisions go out; the caller journals what must be durable. Monotonic time, never less than
// at the call before.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "scheduler/farm_state.h"
#include "scheduler/policy/audits.h"
#include "scheduler/policy/checks.h"
#include "scheduler/policy/classes.h"
#include "scheduler/policy/eligibility.h"
#include "scheduler/policy/faults.h"
#include "scheduler/policy/job_course.h"
#include "scheduler/policy/lease_book.h"
#include "scheduler/policy/leasing.h"
#include "scheduler/policy/paces.h"
#include "scheduler/policy/runs.h"
#include "scheduler/policy/steps.h"
#include "scheduler/policy/trust.h"
#include "scheduler/scheduler_types.h"

namespace tessera::server {

/// Policy in short; figures and reasons are in docs/decisions/0009-scheduling.md.
/// - Turns: priority, then the user who has had least of the farm lately, then that user's oldest job, or the
///   one that has had least (TurnOrder). A worker goes on with a scene that it holds while that is at most
///   Leasing::kAffinitySlackMs ahead of its fair turn, and until work of as much was given out instead of the
///   job whose turn it was.
/// - Runs: units of one tile are leased as one, as many as take SchedulerOptions::longest_run; short ones at
///   first, that a first picture appears, and towards the end of a job [docs/decisions/0020-unit-size.md].
/// - Batches: about SchedulerOptions::batch of work for each thread, less towards the end of a job. When
///   nothing is pending, units that will come late are given to a second worker. The first result of a unit
///   wins.
/// - Phases: the units of a step are given out when all before it is done; what was made of a result that
///   counts no more is made anew [docs/decisions/0026-phases.md].
/// - Faults: a unit that failed goes to another host where there is one, and is set aside after kMaxFailures
/// (unit_failures.h);
///   a host on which that many units fail that fail nowhere else is taken out of that job for a while.
/// - Arithmetic: a job is bound to one arithmetic class of the farm when its first units are given out
///   (ClassTally::best), or to none (JobRequest::any_class). Results are compared within a class only. A job
///   whose class has died out is rendered anew in another one.
/// - Trust: some units are rendered by a second host. Where two disagree, a third decides; the one who is
///   wrong is in quarantine from then on, and what it did for open jobs is done again. Where identities are
///   proven, spots of results are rendered by others, too, and no more than a share of a picture rests on an
///   identity that no other has confirmed (Checks). One identity
///   (identity.h) has one vote, and ends no job and sets no unit aside as long as another one has not been
///   asked.
class Scheduler {
 public:
  explicit Scheduler(const SchedulerOptions& options) : state_(options) {}
  Scheduler(const Scheduler&) = delete;
  Scheduler& operator=(const Scheduler&) = delete;

  /// Returns what has to be journaled, in order, since the call before.
  std::vector<FarmEvent> take_events() { return std::exchange(state_.events, {}); }
  bool has_events() const { return !state_.events.empty(); }

  // ---- jobs. NotFound when there is no such job.

  /// AlreadyExists when the id is taken.
  absl::Status add_job(JobRequest request);
  /// Units of a new job are done, with results of the job `from`; they are numbered from 1 in that order.
  /// Binds the job to their class, if it is to be of one, and ends it when nothing is left to do.
  /// FailedPrecondition when something is done already, or the results are not all of a class that the job
  /// may have.
  absl::Status adopt(std::string_view job, const std::string& from,
                     const std::vector<AdoptedResult>& results);
  /// True when this ended the job; a job that has ended stays as it is.
  absl::StatusOr<bool> cancel_job(std::string_view job);
  /// Puts units that were set aside back, with a clean record. FailedPrecondition when the job ended
  /// otherwise than incomplete.
  absl::Status retry_job(std::string_view job);
  /// FailedPrecondition when the job is over.
  absl::Status pause_job(std::string_view job, bool paused);
  absl::Status set_priority(std::string_view job, std::int32_t priority);
  /// The accepted result of a unit is lost or damaged: the unit is done again, by a job that goes on for it
  /// if it was over. Nothing happens when another result was accepted meanwhile. FailedPrecondition when the
  /// job failed or was cancelled.
  absl::Status revoke_result(std::string_view job, std::uint32_t unit, std::uint64_t sequence,
                             const std::string& why);
  /// Forgets a job that is over; those that await it because it was never done fail. FailedPrecondition when
  /// it is not over.
  absl::Status forget_job(std::string_view job);
  absl::StatusOr<JobView> job(std::string_view id) const;
  /// Why nobody works on an open job; empty when somebody does.
  std::string waiting_for(std::string_view job, Time now) const;
  /// Which workers may not work on an open job for their arithmetic; empty when all may.
  std::string left_out(std::string_view job) const;

  // ---- recovery, before any other call on the job: its results, then its events, both in order.

  /// InvalidArgument for units that do not exist or are done already.
  absl::Status restore_done(std::string_view job, const AcceptedResult& result);
  /// A result was journaled that was revoked later: its number is taken.
  absl::Status restore_revoked(std::string_view job, std::uint32_t sequence);
  absl::Status restore(const FarmEvent& event);
  /// After the last event: ends the job when a crash came between its last result and its end. Gives events.
  absl::Status restored(std::string_view job);

  // ---- workers. NotFound when the worker is not known; it should register again.

  absl::Status register_worker(WorkerInfo info, Time now);
  /// Gives all of its leases back.
  absl::Status deregister_worker(std::string_view worker);
  /// No more leases for it; those that it holds go on.
  absl::Status drain_worker(std::string_view worker);
  std::vector<WorkerView> workers() const;
  /// Who works on what.
  std::vector<Assignment> assignments() const;
  /// The leases of a job that are out, oldest first; none of a job that is not known. Looks at every lease.
  std::vector<Lease> leases_of(std::string_view job) const;
  std::size_t worker_count() const { return state_.workers.size(); }
  /// Empty for a worker that is not known.
  std::string host_of(const std::string& worker) const;
  std::string name_of(const std::string& worker) const;
  /// The kernels with which the worker renders for the job; empty when it may not, or one of both is not
  /// known.
  std::string isa_for(const std::string& worker, std::string_view job) const;
  /// Whether a worker that may be given units computes in this arithmetic class.
  bool has_class(const std::string& name) const { return classes_.has_class(name); }
  /// Whether neither the host nor its identity is in quarantine.
  bool trusts(const std::string& host) const { return trust_.trusts(host); }
  /// The results of the host, or identity, that a person calls `text` (identity.h) count again. NotFound when
  /// no such host is known, FailedPrecondition when several are meant.
  absl::Status trust_host(const std::string& text) { return audits_.trust(text); }
  /// Whether the worker has this very lease at this moment.
  bool holds(std::string_view worker, const v1::LeaseToken& token) const;
  /// Number by which results name a host. The same for the same name as long as the scheduler lives.
  HostNumber number_of_host(const std::string& host) { return state_.number_of_host(host); }

  /// Up to `max_units` units; none when there is nothing for this worker now.
  absl::StatusOr<LeaseDecision> lease(const LeaseRequest& request, Time now);

  /// Keeps the worker and the leases named alive. A lease that expired, or that an earlier coordinator
  /// granted, is taken up again when its unit is still pending.
  absl::StatusOr<HeartbeatDecision> heartbeat(std::string_view worker,
                                              const std::vector<v1::LeaseToken>& leases, Time now);

  /// How often each worker is to be heard of: of thousands, heartbeats would be most of what a coordinator
  /// does. Leases of such farms live longer for it.
  Time heartbeat_interval() const { return book_.heartbeat_interval(); }

  /// A result, of the units that the token names. Valid from any lease of the job's generation, expired or
  /// not. NotFound (job), FailedPrecondition (the job was cancelled, failed, or is of another generation; the
  /// worker is not of the job's class; its host is in quarantine), OutOfRange (unit), AlreadyExists (a
  /// different result was accepted before: one of two is at fault).
  absl::StatusOr<CompleteDecision> complete(std::string_view worker, const v1::LeaseToken& token,
                                            const DeliveredResult& result, Time now);

  /// The worker could not render the unit. Counts once a lease. With `report.scene_fault`, no other would do
  /// better: the job ends when a second identity says so (a second host, where all are of one identity), or
  /// nobody else can be asked.
  absl::Status fail(std::string_view worker, const v1::LeaseToken& token, const FailureReport& report,
                    Time now);

  /// Gives up leases and workers whose time is over.
  Expiry advance(Time now);

  std::size_t leases_out() const { return state_.leases.size(); }
  /// Whether workers are kept waiting until their hands are empty: each result may be what such a worker
  /// waits for.
  bool frees_workers() const { return !state_.freeing.empty(); }

 private:
  using Job = FarmJob;
  using Worker = FarmWorker;

  // ---- scheduler.cpp
  absl::StatusOr<Worker*> find_worker(std::string_view id, Time now);
  /// The job of a token, which must be open and of that generation, and have those units.
  absl::StatusOr<Job*> find_open_job(const v1::LeaseToken& token);
  /// The units that a token names; none when the job has no such run.
  static std::optional<UnitRun> units_of(const Job& job, const v1::LeaseToken& token);
  absl::Status check_may_complete(const Worker& worker, const Job& job) const;
  static bool any_done(const Job& job, const UnitRun& units);
  absl::StatusOr<CompleteDecision> late_result(Job& job, Worker& worker, const UnitRun& units,
                                               const v1::LeaseToken& token, const DeliveredResult& result,
                                               Time now);
  CompleteDecision spot_result(Job& job, Worker& worker, const v1::LeaseToken& token,
                               const DeliveredResult& result, Time now);
  void reconsider(FarmJob& job, std::uint32_t unit, const std::string& why);
  void blame_losses(const std::vector<WorkerInfo>& lost, Time now);
  void drop_worker(std::string_view id);
  void bind_anew(Job& job, Time now);

  // ---- scheduler_jobs.cpp
  absl::StatusOr<Job*> find_job(std::string_view id);
  absl::StatusOr<const Job*> find_job(std::string_view id) const;
  /// kFailedPrecondition where the job is over.
  absl::StatusOr<Job*> find_open_job(std::string_view id);
  /// Ends the job when nothing of it is left to do. Audits that nobody can make are given up.
  void settle(Job& job, Time now);

  FarmState state_;
  // Each leans on those before it.
  Trust trust_{state_};
  Classes classes_{state_, trust_};
  Eligibility eligibility_{state_, trust_, classes_};
  Runs runs_{state_};
  LeaseBook book_{state_, runs_};
  JobCourse course_{state_, book_};
  Faults faults_{state_, trust_, eligibility_, book_, course_};
  Steps steps_{state_, book_, faults_};
  Audits audits_{state_, trust_, classes_, eligibility_, book_, steps_, faults_};
  Paces paces_{state_, classes_};
  Checks checks_{state_, classes_, eligibility_, book_, audits_};
  Leasing leasing_{state_, trust_, classes_, eligibility_, runs_, book_, audits_, checks_};
};

}  // namespace tessera::server
