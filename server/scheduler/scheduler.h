// The farm's state machine: jobs, units, leases and workers. Pure: no clock, no I/O, no threads. Time and events come
// in, decisions go out; the caller journals what must be durable. Monotonic time, never less than at the call before.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/status/statusor.h"
#include "scheduler/lease_table.h"
#include "scheduler/unit_ledger.h"
#include "scheduler/work_plan.h"
#include "tessera/v1/job.pb.h"
#include "tessera/v1/work.pb.h"

namespace tessera::server {

struct SchedulerOptions {
  Time lease_timeout{8000};  // a lease, and a worker, that was not heard of for so long is given up
  Time min_copy_age{500};    // a unit is not copied to a second worker before it was out for so long
  std::uint64_t epoch = 1;   // of the coordinator; part of every token
};

struct JobRequest {
  std::string id;
  std::shared_ptr<const WorkPlan> plan;
  std::string scene_digest;
  std::string isa;            // empty: that of the first worker
  std::int32_t priority = 0;  // higher goes first
  std::uint32_t generation = 1;
};

struct JobView {
  v1::JobState state = v1::QUEUED;
  std::uint32_t units_total = 0, units_done = 0, units_leased = 0;
  std::string isa;    // empty until bound
  std::string error;  // why it failed
};

struct WorkerInfo {
  std::string id;    // never used before
  std::string name;  // for people
  std::string build;
  std::string isa;  // the one it would choose
  std::vector<std::string> supported_isas;
  std::uint32_t threads = 1;
};

struct WorkerView {
  WorkerInfo info;
  std::uint32_t leases = 0;
  std::uint64_t units_done = 0;
  bool draining = false;
  Time last_seen{};
};

struct LeaseRequest {
  std::string worker;
  std::uint32_t max_units = 1;
  std::vector<std::string> loaded_scenes;  // digests of the scenes that it holds
};

struct LeaseDecision {
  std::vector<v1::Lease> leases;
  /// Jobs that these leases bound to an ISA. To be durable before the leases go out.
  std::vector<std::string> bound_jobs;
};

struct HeartbeatDecision {
  std::vector<v1::LeaseToken> revoked;
  bool drain = false;
};

struct CompleteDecision {
  bool duplicate = false;      // the same result was accepted before: nothing changed
  std::uint64_t sequence = 0;  // of the result within its job, from 1; 0 for a duplicate
  bool job_done = false;       // this was the last unit
};

struct FailDecision {
  bool job_failed = false;
};

/// What the passage of time did.
struct Expiry {
  std::vector<WorkerInfo> lost_workers;
  std::uint32_t lost_leases = 0;
};

/// Policy in short. Jobs by priority, then least leases out, then age. A worker that holds a job's scene gets that job
/// as long as it is at most kAffinitySlack leases ahead of its fair turn. A unit that has failed goes to another worker
/// where there is one; after kMaxFailures the job fails. When nothing is pending, units that take longer than others
/// are given to a second worker. The first result of a unit wins, whoever it comes from.
class Scheduler {
 public:
  static constexpr std::uint32_t kMaxFailures = 3;
  static constexpr std::size_t kMaxCopies = 2;  // leases of one unit at a time
  static constexpr std::uint32_t kAffinitySlack = 4;

  explicit Scheduler(const SchedulerOptions& options);

  // ---- jobs. NotFound when there is no such job.

  /// AlreadyExists when the id is taken.
  absl::Status add_job(JobRequest request);
  /// Recovery, before any lease: the unit is done. InvalidArgument for a unit that does not exist or is done already.
  absl::Status restore_done(std::string_view job, std::uint32_t unit, ResultFingerprint result);
  /// True when this ended the job; a job that has ended stays as it is.
  absl::StatusOr<bool> cancel_job(std::string_view job);
  absl::StatusOr<JobView> job(std::string_view id) const;

  // ---- workers. NotFound when the worker is not known; it should register again.

  absl::Status register_worker(WorkerInfo info, Time now);
  /// Gives all of its leases back.
  absl::Status deregister_worker(std::string_view worker);
  /// No more leases for it; those that it holds go on.
  absl::Status drain_worker(std::string_view worker);
  std::vector<WorkerView> workers() const;

  /// Up to `max_units` units; none when there is nothing for this worker now.
  absl::StatusOr<LeaseDecision> lease(const LeaseRequest& request, Time now);

  /// Keeps the worker and the leases named alive. A lease that expired, or that an earlier coordinator granted, is
  /// taken up again when its unit is still pending.
  absl::StatusOr<HeartbeatDecision> heartbeat(std::string_view worker, const std::vector<v1::LeaseToken>& leases,
                                              Time now);

  /// A result. Valid from any lease of the job's generation, expired or not. NotFound (job), FailedPrecondition (the
  /// job was cancelled, failed, or is of another generation; the worker's ISA is not the job's), OutOfRange (unit),
  /// AlreadyExists (a different result was accepted before: a fault).
  absl::StatusOr<CompleteDecision> complete(std::string_view worker, const v1::LeaseToken& token,
                                            ResultFingerprint result, Time now);

  /// The worker could not render the unit. Counts once a lease. `scene_fault` ends the job.
  absl::StatusOr<FailDecision> fail(std::string_view worker, const v1::LeaseToken& token, const std::string& message,
                                    bool scene_fault, Time now);

  /// Gives up leases and workers whose time is over.
  Expiry advance(Time now);

  std::size_t leases_out() const { return leases_.size(); }

 private:
  struct Failures {
    std::uint32_t count = 0;
    std::vector<std::string> workers;
  };

  struct Job {
    Job(std::uint64_t job_number, JobRequest job_request)
        : number(job_number), request(std::move(job_request)), units(request.plan->unit_count()) {}

    std::uint64_t number;  // in order of submission
    JobRequest request;
    UnitLedger units;
    v1::JobState state = v1::QUEUED;
    std::string error;
    std::uint32_t leases = 0;
    std::uint32_t attempts = 0;  // grants so far
    Time mean_duration{0};       // from grant to result, moving average; 0 before the first result
    absl::flat_hash_map<std::uint32_t, Failures> failures;
    std::set<std::pair<Time, LeaseId>> only_leases;  // whose unit has no second lease; oldest first

    bool open() const { return state == v1::QUEUED || state == v1::RUNNING; }
  };

  struct Worker {
    WorkerInfo info;
    std::uint64_t units_done = 0;
    bool draining = false;
    Time last_seen{};

    bool supports(const std::string& isa) const;
  };

  // Jobs in the order in which they are served: priority, fewest leases, oldest.
  using Turn = std::tuple<std::int64_t, std::uint32_t, std::uint64_t>;
  static Turn turn(const Job& job) { return {-std::int64_t{job.request.priority}, job.leases, job.number}; }

  absl::StatusOr<Job*> find_job(std::string_view id);
  absl::StatusOr<const Job*> find_job(std::string_view id) const;
  absl::StatusOr<Worker*> find_worker(std::string_view id, Time now);
  /// The job of a token, which must be open and of that generation, and have that unit.
  absl::StatusOr<Job*> find_open_job(const v1::LeaseToken& token);
  std::optional<LeaseId> find_lease(const Job& job, const v1::LeaseToken& token, std::string_view worker) const;

  struct Batch;  // one call of lease()
  Job* choose_job(const Batch& batch);
  bool lease_pending(Batch& batch);
  bool lease_copy(Batch& batch);
  bool may_work_on(const Worker& worker, const Job& job) const;
  bool avoids(const Worker& worker, const Job& job, std::uint32_t unit) const;
  void grant(Batch& batch, Job& job, std::uint32_t unit);
  bool take_up(const Worker& worker, Job& job, const v1::LeaseToken& token, Time now);
  Time copy_age(const Job& job) const;

  void add_lease(Job& job, Lease lease);
  /// The unit goes back to pending when it is not done and this was its last lease.
  void drop_lease(LeaseId id);
  void drop_worker(std::string_view id);
  void end_job(Job& job, v1::JobState state, std::string error);
  /// Changes the count of leases, by which jobs take turns.
  void set_leases(Job& job, std::uint32_t leases);

  SchedulerOptions options_;
  std::vector<std::unique_ptr<Job>> jobs_;  // by number
  absl::flat_hash_map<std::string, Job*> jobs_by_id_;
  std::set<Turn> turns_;  // open jobs
  absl::flat_hash_map<std::string, Worker> workers_;
  LeaseTable leases_;
};

}  // namespace tessera::server
