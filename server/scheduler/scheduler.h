// The farm's state machine: jobs, units, leases and workers. Pure: no clock, no I/O, no threads. Time and
// events come in, decisions go out; the caller journals what must be durable. Monotonic time, never less than
// at the call before.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/status/statusor.h"
#include "scheduler/class_census.h"
#include "scheduler/farm_event.h"
#include "scheduler/farm_state.h"
#include "scheduler/lease_table.h"
#include "scheduler/scheduler_types.h"
#include "scheduler/turn_order.h"

namespace tessera::server {

/// Policy in short; figures and reasons are in docs/decisions/0009-scheduling.md.
/// - Turns: priority, then the user who has had least of the farm lately, then that user's oldest job, or the
///   one that has had least (TurnOrder). A worker goes on with a scene that it holds while that is at most
///   kAffinitySlackMs ahead of its fair turn, and until work of kAffinitySlackMs was given out instead of the
///   job whose turn it was.
/// - Runs: units of one tile are leased as one, as many as take SchedulerOptions::longest_run; short ones at
///   first, that a first picture appears, and towards the end of a job [docs/decisions/0020-unit-size.md].
/// - Batches: about SchedulerOptions::batch of work for each thread, less towards the end of a job. When
///   nothing is pending, units that will come late are given to a second worker. The first result of a unit
///   wins.
/// - Phases: the units of a step are given out when all before it is done; what was made of a result that
///   counts no more is made anew [docs/decisions/0026-phases.md].
/// - Faults: a unit that failed goes to another host where there is one, and is set aside after kMaxFailures;
///   a host on which that many units fail that fail nowhere else is taken out of that job for a while.
/// - Arithmetic: a job is bound to the arithmetic class that most threads of the farm have when its first
///   units are given out, or to none (JobRequest::any_class). Results are compared within a class only.
/// - Trust: some units are rendered by a second host. Where two disagree, a third decides; the one who is
///   wrong is in quarantine from then on, and what it did for open jobs is done again. One identity
///   (identity.h) has one vote, and ends no job and sets no unit aside as long as another one has not been
///   asked.
class Scheduler {
 public:
  static constexpr std::uint32_t kMaxFailures = 3;      // on different hosts, or reported by any worker
  static constexpr std::uint32_t kMaxLosses = 6;        // failures of any kind on any number of hosts
  static constexpr std::uint32_t kLossesToIsolate = 2;  // from then on a unit is a worker's only one
  static constexpr std::size_t kMaxCopies = 2;          // leases of one unit at a time, second opinions apart
  static constexpr std::int64_t kAffinitySlackMs = 4000;
  static constexpr std::int64_t kUnknownCostMs = 1000;       // of a unit, before any is done
  static constexpr std::uint32_t kRunPieces = 16;            // into which a run is cut that was not rendered
  static constexpr std::size_t kHeartbeatsPerSecond = 2000;  // that are bearable
  static constexpr Time kLongestHeartbeat{5000};
  static constexpr Time kFirstBar{60'000};  // doubled each time
  static constexpr Time kLongestBar{3'600'000};
  static constexpr std::size_t kMaxListed = 64;  // set-aside units and notes kept for people
  static constexpr std::size_t kMaxClosedJobs = 8;

  explicit Scheduler(const SchedulerOptions& options);

  /// Returns what has to be journaled, in order, since the call before.
  std::vector<FarmEvent> take_events() { return std::exchange(events_, {}); }
  bool has_events() const { return !events_.empty(); }

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
  /// Forgets a job that is over. FailedPrecondition when it is not.
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
  std::size_t worker_count() const { return workers_.size(); }
  /// Empty for a worker that is not known.
  std::string host_of(const std::string& worker) const;
  std::string name_of(const std::string& worker) const;
  /// The kernels with which the worker renders for the job; empty when it may not, or one of both is not
  /// known.
  std::string isa_for(const std::string& worker, std::string_view job) const;
  /// Whether a worker that may be given units computes in this arithmetic class.
  bool has_class(const std::string& name) const;
  /// Whether neither the host nor its identity is in quarantine.
  bool trusts(const std::string& host) const { return !why_distrusted(host); }
  /// The results of the host, or identity, that a person calls `text` (identity.h) count again. NotFound when
  /// no such host is known, FailedPrecondition when several are meant.
  absl::Status trust_host(const std::string& text);
  /// Whether the worker has this very lease at this moment.
  bool holds(std::string_view worker, const v1::LeaseToken& token) const;
  /// Number by which results name a host. The same for the same name as long as the scheduler lives.
  HostNumber number_of_host(const std::string& host);

  /// Up to `max_units` units; none when there is nothing for this worker now.
  absl::StatusOr<LeaseDecision> lease(const LeaseRequest& request, Time now);

  /// Keeps the worker and the leases named alive. A lease that expired, or that an earlier coordinator
  /// granted, is taken up again when its unit is still pending.
  absl::StatusOr<HeartbeatDecision> heartbeat(std::string_view worker,
                                              const std::vector<v1::LeaseToken>& leases, Time now);

  /// How often each worker is to be heard of: of thousands, heartbeats would be most of what a coordinator
  /// does. Leases of such farms live longer for it.
  Time heartbeat_interval() const;

  /// A result, of the units that the token names. Valid from any lease of the job's generation, expired or
  /// not. NotFound (job), FailedPrecondition (the job was cancelled, failed, or is of another generation; the
  /// worker is not of the job's class; its host is in quarantine), OutOfRange (unit), AlreadyExists (a
  /// different result was accepted before: one of two is at fault).
  absl::StatusOr<CompleteDecision> complete(std::string_view worker, const v1::LeaseToken& token,
                                            const DeliveredResult& result, Time now);

  /// The worker could not render the unit. Counts once a lease. With `scene_fault`, no other would do better:
  /// the job ends when a second identity says so (a second host, where all are of one identity), or nobody
  /// else can be asked.
  absl::Status fail(std::string_view worker, const v1::LeaseToken& token, const std::string& message,
                    bool scene_fault, Time now);

  /// Gives up leases and workers whose time is over.
  Expiry advance(Time now);

  std::size_t leases_out() const { return leases_.size(); }
  /// Whether workers are kept waiting until their hands are empty: each result may be what such a worker
  /// waits for.
  bool frees_workers() const { return !freeing_.empty(); }

 private:
  using Job = FarmJob;
  using Worker = FarmWorker;

  // ---- scheduler.cpp
  absl::StatusOr<Worker*> find_worker(std::string_view id, Time now);
  /// The job of a token, which must be open and of that generation, and have those units.
  absl::StatusOr<Job*> find_open_job(const v1::LeaseToken& token);
  /// The units that a token names; none when the job has no such run.
  static std::optional<UnitRun> units_of(const Job& job, const v1::LeaseToken& token);
  std::optional<LeaseId> find_lease(const Job& job, const v1::LeaseToken& token,
                                    std::string_view worker) const;
  absl::Status check_may_complete(const Worker& worker, const Job& job) const;
  static bool any_done(const Job& job, const UnitRun& units);
  absl::StatusOr<CompleteDecision> late_result(Job& job, Worker& worker, const UnitRun& units,
                                               const v1::LeaseToken& token, const DeliveredResult& result,
                                               Time now);
  void measure(Job& job, Worker& worker, const Lease& lease, const DeliveredResult& result, Time now);
  void compare_workers();
  /// A new event, for the caller to fill in.
  FarmEvent& record(FarmEvent::Kind kind, const std::string& job);
  void note(Job& job, std::string text);

  // ---- scheduler_jobs.cpp
  absl::StatusOr<Job*> find_job(std::string_view id);
  absl::StatusOr<const Job*> find_job(std::string_view id) const;
  /// kFailedPrecondition where the job is over.
  absl::StatusOr<Job*> find_open_job(std::string_view id);
  void take_turns(Job& job);
  void leave_turns(const Job& job);
  /// Ends the job when nothing of it is left to do. Audits that nobody can make are given up.
  void settle(Job& job);
  void end_job(Job& job, v1::JobState state, std::string error);

  // ---- scheduler_leasing.cpp
  struct Batch;  // one call of lease()
  bool has_units_for(const Batch& batch, const Job& job) const;
  Job* choose_job(Batch& batch);
  bool lease_pending(Batch& batch);
  bool lease_copy(Batch& batch);
  bool lease_audit(Batch& batch);
  bool lease_dangerous(Batch& batch);
  bool has_room(const Batch& batch, const Job& job) const;
  bool is_left(const Batch& batch, std::int32_t priority, std::uint64_t wanted) const;
  bool would_come_late(const Batch& batch, const Job& job) const;
  bool may_work_on(const Worker& worker, const Job& job, Time now) const;
  bool avoids(const Worker& worker, const Job& job, std::uint32_t unit) const;
  void grant(Batch& batch, Job& job, const UnitRun& units, bool audit);
  std::optional<LeaseId> find_own_lease(const Job& job, const UnitRun& units, std::string_view worker) const;
  bool take_up(Worker& worker, Job& job, const UnitRun& units, const v1::LeaseToken& token, Time now);
  Time lease_time() const;
  void add_lease(Job& job, Worker& worker, Lease lease);
  /// Its units go back to pending when they are leased and this was their last lease.
  void drop_lease(LeaseId id);
  void index_only_lease(Job& job, const UnitRun& units, bool add);
  void drop_worker(std::string_view id);

  // ---- scheduler_phases.cpp
  static void open_steps(Job& job);
  static std::optional<std::uint64_t> inputs_of(const Job& job, std::uint32_t unit);
  /// FailedPrecondition where the lease was of units that read other results than those that count now.
  static absl::Status check_inputs(const Job& job, const v1::LeaseToken& token);
  void revoke_dependents(Job& job, std::uint32_t source);
  void begin_anew(Job& job, std::uint32_t unit);
  void revoke_orphans(Job& job);

  // ---- scheduler_runs.cpp
  double unit_cost_ms(const Job& job, const UnitRun& units) const;
  std::int64_t charge_for(const Job& job, const UnitRun& units) const;
  Time expected_cost(const Worker& worker, const Job& job, const UnitRun& units) const;
  UnitRun run_from(const Worker& worker, const Job& job, std::uint32_t unit) const;
  bool fits_run(const Job& job, std::uint32_t unit, std::uint32_t count) const;
  double longest_run(const Worker& worker, const Job& job, const UnitRun& units) const;

  // ---- scheduler_classes.cpp
  /// Takes the worker into the census while it may be given units, and out of it otherwise.
  void count(Worker& worker);
  const std::string& class_of(const Job& job) const;
  const std::string* class_for(const Worker& worker, const Job& job) const;
  const std::string& class_of_result(const Job& job, const AcceptedResult& result) const;
  bool settling(const Job& job, Time now) const;
  void bind(Job& job, const std::string& name);
  void note_class(Job& job, const std::string& host, std::uint32_t sequence, const std::string& name);
  std::vector<std::string> closed_jobs(const Worker& worker) const;

  // ---- scheduler_faults.cpp
  void record_failure(const Job& job, std::uint32_t unit, const UnitFailure& failure);
  void add_failure(Job& job, std::uint32_t unit, UnitFailure failure, Time now);
  void blame_loss(const std::vector<WorkerInfo>& lost, Time now);
  void absolve(Job& job, const v1::LeaseToken& token, const std::string& host);
  void judge_unit(Job& job, std::uint32_t unit);
  bool awaits_another(const Job& job, const std::vector<UnitFailure>& failures) const;
  void judge_scene(Job& job, const std::string& message, Time now);
  Time bar(Job& job, const std::string& host, Time now);
  void cut_run(Job& job, const UnitRun& units, const UnitFailure& failure);
  static void shorten_runs(Job& job, const UnitRun& units);
  void forgive(Job& job, std::uint32_t unit);
  void judge_host(Job& job, std::uint32_t unit, const std::string& host, Time now);
  void reopen(Job& job);
  std::string what_is_missing(const Job& job) const;

  // ---- scheduler_audit.cpp
  void restore_audits(Job& job);
  void restore_audit(Job& job, const FarmEvent& event);
  Audit first_opinion(const Job& job, const AcceptedResult& accepted) const;
  bool audit_wanted(const Job& job, const AcceptedResult& accepted) const;
  bool is_of_one_identity() const;
  std::optional<std::string> why_distrusted(const std::string& host) const;
  bool may_speak(const Audit& audit, const std::string& host) const;
  bool can_audit(const Worker& worker, const Job& job, const Audit& audit) const;
  bool anyone_can_audit(const Job& job, const Audit& audit) const;
  absl::StatusOr<CompleteDecision> second_result(Job& job, const Worker& worker,
                                                 const AcceptedResult& accepted, ResultFingerprint result);
  void adjudicate(Job& job, std::uint32_t unit);
  void distrust(const std::string& subject, const std::string& why);
  void revoke_results(Job& job, const std::string& subject);
  void revoke(Job& job, const AcceptedResult& result);
  void revoke_alone(Job& job, const AcceptedResult& result);

  SchedulerOptions options_;
  std::uint64_t jobs_added_ = 0;
  std::map<std::uint64_t, std::unique_ptr<Job>> jobs_;  // by number
  absl::flat_hash_map<std::string, Job*> jobs_by_id_;
  TurnOrder turns_;                                                          // open jobs that are not paused
  absl::flat_hash_map<std::string, std::set<std::uint64_t>> jobs_by_scene_;  // the same, by digest
  std::set<std::uint64_t> auditing_;                                         // open jobs with audits to make
  std::set<std::uint64_t> endangered_;                                       // open jobs with dangerous units
  std::set<std::string> freeing_;  // workers that get nothing until they can take a dangerous unit alone
  absl::flat_hash_map<std::string, Worker> workers_;
  std::uint64_t workers_added_ = 0;
  std::uint64_t threads_ = 0;  // of all workers
  UsualPace usual_pace_;
  std::size_t results_since_comparison_ = 0;       // of workers' paces
  std::map<std::string, std::size_t> identities_;  // that answer for the workers, and for how many
  ClassCensus census_;
  Time settled_at_{};  // when the last new kind of worker will have been there for SchedulerOptions::settle
  LeaseTable leases_;
  std::vector<std::string> hosts_;  // by number
  absl::flat_hash_map<std::string, HostNumber> host_numbers_;
  std::map<std::string, std::string> distrusted_;  // host or identity -> why
  std::vector<FarmEvent> events_;
};

}  // namespace tessera::server
