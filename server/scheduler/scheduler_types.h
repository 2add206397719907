// Input and output of the scheduler.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scheduler/lease_table.h"
#include "scheduler/spot_table.h"
#include "scheduler/turn_order.h"
#include "scheduler/unit_ledger.h"
#include "scheduler/work_plan.h"
#include "tessera/v1/job.pb.h"
#include "tessera/v1/work.pb.h"

namespace tessera::server {

struct SchedulerOptions {
  Time heartbeat_interval{1000};  // interval of each worker; longer in large farms
  Time lease_timeout{8000};       // a lease, and a worker, that was not heard of for so long is given up
  Time min_copy_age{500};         // a unit is not copied to a second worker before it was out for so long
  Time batch{10'000};        // most work leased for each thread of a worker, once the cost of units is known
  Time longest_run{10'000};  // upper bound of a run's time, as measured; 0: units are leased one at a time
  Time short_run{100};       // a run that is always worth a lease of its own
  std::uint32_t audit_one_in = 100;  // results, that a second host renders again; 0: none
  // The same of results of phases, which all of a picture is made of, where hosts are of several identities.
  std::uint32_t audit_phases_one_in = 1;
  JobOrder order = JobOrder::kFirstCome;
  std::uint64_t epoch = 1;          // epoch of the coordinator; part of every token
  double unconfirmed_share = 0.05;  // part of a job's units that may rest on an unconfirmed identity
  double spot_work = 0.0175;        // part of a job's work, that is spent on spots of results
  // Chooses results for audits: whoever knows it knows where to be honest. The same after a
  // restart.
  std::string audit_key = {};
  // A job is bound to an arithmetic class only when no worker of a new one has come for so long: of workers
  // that are started together, the first is not to decide for all.
  Time settle{0};
  // Arithmetic classes that the operator vouches for.
  std::vector<std::string> classes = {};
  // A job that has results is bound anew when no worker of its class was there for so long.
  Time class_patience{600'000};
};

struct JobRequest {
  std::string id;
  std::shared_ptr<const WorkPlan> plan;
  std::string scene_digest;
  std::string isa;            // the only one that workers may use; empty: any
  std::int32_t priority = 0;  // higher goes first
  std::uint32_t generation = 1;
  std::string user;
  std::vector<std::string> required_tags;
  std::uint32_t max_workers = 0;        // workers at a time; 0: any number
  bool any_class = false;               // workers of every arithmetic class may work on it; else of one
  std::vector<std::string> after = {};  // jobs that have to be done first
  std::string bound_class = {};         // the class from before a restart; empty: not bound yet
};

/// A worker's words on a unit that it could not render.
struct FailureReport {
  std::string message;
  bool scene_fault = false;           // No other worker would do better.
  bool inputs_fault = false;          // the blobs that the unit reads are none that it can be made of
  std::vector<std::string> log = {};  // the last lines of the worker's own, for people
};

/// One time that a unit was not rendered.
struct UnitFailure {
  std::string host;
  std::string message;
  bool lost = false;          // the worker died or went silent
  bool scene_fault = false;   // The worker says that no other worker would do better.
  bool inputs_fault = false;  // the worker could not read what the unit is made of
  bool disputed =
      false;  // the unit was made, but two identities disagree on what it makes, and no third is there
  std::int64_t grant = 0;  // the lease that ended so (grant_id)
};

struct SetAsideView {
  std::uint32_t unit = 0;
  std::vector<UnitFailure> failures;
};

struct JobView {
  v1::JobState state = v1::QUEUED;
  std::uint32_t units_total = 0, units_done = 0, units_leased = 0, units_set_aside = 0;
  std::uint32_t units_open = 0;     // units of the steps that were begun, which come first
  std::uint32_t units_pending = 0;  // units that may be leased now; others wait for an earlier step
  std::string isa;                  // the ISA of `classes`; without any, the one asked for
  std::string error;                // why it failed, or what is missing
  std::int32_t priority = 0;
  bool paused = false;
  std::uint32_t revision = 0;           // times that accepted results were thrown away
  std::vector<std::string> notes;       // Tells people what went wrong where.
  std::vector<SetAsideView> set_aside;  // the first kMaxListed
  std::uint32_t audits = 0;             // units that a second host was asked to render too
  std::uint32_t audits_out = 0;         // audits that a worker is busy with
  std::uint32_t units_unconfirmed = 0;  // units that rest on unconfirmed identities
  std::uint32_t units_adopted = 0;      // taken over from another job
  std::string adopted_from;
  std::vector<std::string> classes = {};  // classes of its results, the bound one first (ClassHistory::all)
  std::uint32_t workers = 0;              // workers that hold units of it
  std::vector<std::string> awaited = {};  // jobs that are not done yet, and have to be first
};

struct WorkerInfo {
  std::string id;    // never used before
  std::string name;  // shown to people
  std::string build;
  std::string isa;  // the one it would choose
  std::vector<std::string> supported_isas;
  std::uint32_t threads = 1;
  std::string host;  // Faults are counted by it; it names who answers for it (identity.h).
  std::vector<std::string> tags;
  // Whence it registered, for people: the name in its certificate, and its address. Empty where these are not
  // known.
  std::string certificate = {}, peer = {};
  // Arithmetic class with each of supported_isas, in their order. Empty: what the ISAs are called.
  std::vector<std::string> classes = {};
};

struct WorkerView {
  WorkerInfo info;
  std::uint32_t leases = 0;
  std::uint64_t units_done = 0;
  bool draining = false;
  Time last_seen{};
  std::string quarantine;                     // why its host is not trusted; empty when it is
  double slowness = 1;                        // time that its units take, relative to the usual worker
  std::vector<std::string> closed_jobs = {};  // open, and not for its arithmetic: the first kMaxClosedJobs
};

/// A worker that has units of a job in its hands.
struct Assignment {
  std::string job, worker;  // ids
  std::uint32_t leases = 0;
};

struct LeaseRequest {
  std::string worker;
  std::uint32_t max_units = 1;
  std::vector<std::string> loaded_scenes;  // digests of the scenes that it holds
};

struct LeaseDecision {
  std::vector<v1::Lease> leases;
};

struct HeartbeatDecision {
  std::vector<v1::LeaseToken> revoked;
  bool drain = false;
};

/// A result as a worker brings it.
struct DeliveredResult {
  ResultFingerprint fingerprint = 0;
  std::chrono::nanoseconds cost{0};  // wall time that the unit took; 0: not known
  // How much there was to do in it, in a measure by which units of one job differ less than by their cost
  // (rays that were traced); 0: not known.
  std::uint64_t work = 0;
  Spot spot = {};
};

/// A result that another job has of the same pixels and samples.
struct AdoptedResult {
  UnitRun units;  // units of the new job
  ResultFingerprint fingerprint = 0;
  std::string host;  // the host that rendered it
  std::string arithmetic_class;
};

struct CompleteDecision {
  // How long the lease was out, on how many threads at most; none where it began before this coordinator
  // did, or is not known any more.
  std::optional<Time> lasted = {};
  std::uint32_t threads = 1;
  bool duplicate = false;      // The same result was accepted before; nothing changed.
  std::uint64_t sequence = 0;  // number of the result within its job, from 1; 0: a duplicate
  bool opened = false;         // units may be leased now that had to wait for this one
};

/// Effects of the passage of time.
struct Expiry {
  std::vector<WorkerInfo> lost_workers;
  std::uint32_t lost_leases = 0;
};

/// One number for one lease, unique within the job: the epoch above, the attempt below.
inline std::int64_t grant_id(std::uint64_t epoch, std::uint32_t attempt) {
  return static_cast<std::int64_t>(epoch << 32 | attempt);
}

}  // namespace tessera::server
