// State of the farm: jobs, workers, leases, and the events to be journaled. Policies (policy/) work on it;
// the scheduler alone makes one.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "scheduler/audit_table.h"
#include "scheduler/class_history.h"
#include "scheduler/class_tally.h"
#include "scheduler/farm_event.h"
#include "scheduler/lease_table.h"
#include "scheduler/scheduler_types.h"
#include "scheduler/spot_table.h"
#include "scheduler/turn_order.h"
#include "scheduler/unit_ledger.h"
#include "scheduler/worker_pace.h"

namespace tessera::server {

/// How one host fares with one job.
struct HostRecord {
  std::set<std::uint32_t> units_failed_only_here;
  std::uint32_t bars = 0;  // times that it was taken out; success clears it
  Time barred_until{};
};

/// Costs of the latest results' units on one thread of a usual worker, in ms. So few of one identity count
/// that those of others are always among them.
class LatestCosts {
 public:
  static constexpr std::size_t kKept = 16, kKeptOfOne = 4, kFewest = 3;

  void add(const std::string& identity, double unit_ms);
  /// The median of what others have returned; none where that is less than kFewest results.
  std::optional<double> of_others(const std::string& identity) const;
  void clear() { latest_.clear(); }

 private:
  std::vector<std::pair<std::size_t, double>> latest_;  // hash of the identity, cost; the oldest first
};

struct FarmJob {
  FarmJob(std::uint64_t job_number, JobRequest job_request)
      : number(job_number),
        request(std::move(job_request)),
        units(request.plan->unit_count()),
        pace(job_number) {}

  std::uint64_t number;  // ascends in order of submission
  JobRequest request;
  UnitLedger units;
  v1::JobState state = v1::QUEUED;
  std::string error;
  bool paused = false;
  std::set<std::string> awaited;  // jobs that have to be done before units of this one are given out
  std::uint32_t leases = 0;
  std::int64_t leased_work_ms = 0;  // sum of Lease::charge_ms
  // Work that was given out instead of this job's since it last had a unit, though its turn was first.
  std::int64_t passed_over_ms = 0;
  std::uint32_t attempts = 0;  // grants so far
  std::uint32_t results = 0;   // accepted so far, those revoked included
  std::uint32_t revision = 0;
  Time mean_lease_duration{0};   // moving average from grant to result; 0 before the first result
  double mean_unit_cost_ms = 0;  // moving average on one thread of a usual worker; 0 before the first result
  LatestCosts latest_costs;
  // The same of a unit of each tile, as in its latest result; 0: not known. Empty where a tile is one unit.
  std::vector<float> tile_cost_ms;
  JobPace pace;
  std::vector<std::string> notes;
  std::uint32_t adopted = 0;  // results taken over
  std::string adopted_from;
  ClassHistory classes{request.bound_class};
  // The class that it would be bound to, as of a revision of the tally.
  mutable std::uint64_t class_tally_revision = 0;
  mutable std::string best_class;
  mutable std::optional<Time> settling_since;  // time when a unit was first withheld for that choice
  std::optional<Time> forsaken_since;          // time from which on no worker of its class is there

  /// Failures by unit, kept until it is done.
  absl::flat_hash_map<std::uint32_t, std::vector<UnitFailure>> failures;
  // Units of runs that failed or were lost: the longest run that they may be part of.
  absl::flat_hash_map<std::uint32_t, std::uint32_t> shorter_runs;
  std::set<std::uint32_t> dangerous;  // units that are not done and were lost with kLossesToIsolate workers
  std::map<std::string, HostRecord> hosts;
  std::map<std::string, std::string>
      scene_faults;  // host that says that the scene is at fault -> its message
  std::set<HostNumber> hosts_with_results;
  AuditTable audits;                // waiting and under way
  std::set<std::uint32_t> audited;  // first units of results of which a second opinion was asked once
  SpotTable spots;                  // waiting and under way
  std::map<std::string, Standing> standing_by_identity;
  absl::flat_hash_map<std::uint32_t, std::string> alarms;  // first unit of a result -> whose spot differed
  std::uint32_t units_unconfirmed = 0;                     // Checks::unconfirmed_units when the job ended
  // Units of phases by what is known of their results: of which two identities say the same; that somebody
  // could not read, and steps wait for a second opinion; of which one was asked for that reason.
  std::set<std::uint32_t> confirmed, suspected, questioned;
  std::uint32_t reached = 0;  // units below it were open before steps were closed, and may be done
  absl::flat_hash_map<std::string, std::uint32_t> holders;  // worker -> leases
  std::set<std::pair<Time, LeaseId>> only_leases;  // leases whose unit has no second one; oldest first
  std::set<std::pair<Time, LeaseId>> by_end;       // the same leases, by expected end

  bool open() const { return state == v1::QUEUED || state == v1::RUNNING; }
  bool held() const { return paused || !awaited.empty(); }
};

struct FarmWorker {
  WorkerInfo info;
  std::uint64_t units_done = 0;
  bool draining = false;
  Time last_seen{};
  WorkerPace pace{};
  double slowness = 1;       // time that its units take, relative to the usual worker
  std::int64_t load_ms = 0;  // work in hand, as a usual worker would need on one thread
  std::uint64_t leased_units = 0;
  bool isolated = false;  // holds a dangerous unit, and so nothing else
  bool is_tallied = false;
  std::uint32_t counted_threads = 1;  // the number that the worker claims, or that was measured
  // Time in which it held leases, and of that what its results say that its threads worked.
  Time busy{0}, busy_until{0};
  double worked_ms = 0;
  std::uint32_t measured_results = 0;
};

struct FarmState {
  static constexpr std::size_t kMaxListed = 64;  // set-aside units and notes kept for people

  explicit FarmState(const SchedulerOptions& scheduler_options)
      : options(scheduler_options), turns(options.order), class_tally(options.classes) {}

  /// A new event, for the caller to fill in.
  FarmEvent& record(FarmEvent::Kind kind, const std::string& job);
  /// Something that people are to know of the job.
  void note(FarmJob& job, std::string text);
  /// The same for the same host as long as the state lives.
  HostNumber number_of_host(const std::string& host);

  const SchedulerOptions options;
  std::uint64_t jobs_added = 0;
  std::map<std::uint64_t, std::unique_ptr<FarmJob>> jobs_by_number;
  absl::flat_hash_map<std::string, FarmJob*> jobs_by_id;
  TurnOrder turns;  // open jobs that are not held
  /// The same jobs, by the scene's digest.
  absl::flat_hash_map<std::string, std::set<std::uint64_t>> jobs_by_scene;
  absl::flat_hash_map<std::string, std::set<std::uint64_t>> awaiting;  // open jobs, by the one they await
  std::set<std::uint64_t> auditing;                                    // open jobs with audits to make
  std::set<std::uint64_t> checking;                                    // open jobs with spots to render
  std::set<std::uint64_t> endangered;                                  // open jobs with dangerous units
  std::set<std::string> freeing;  // workers that get nothing until they can take a dangerous unit alone
  absl::flat_hash_map<std::string, FarmWorker> workers;
  std::uint64_t workers_added = 0;
  std::uint64_t total_threads = 0;  // sum of FarmWorker::counted_threads
  UsualPace usual_pace;
  std::size_t results_since_pace_comparison = 0;
  std::map<std::string, std::set<std::string>> workers_by_identity;  // ids
  ClassTally class_tally;
  /// Time when the last new kind of worker will have been there for SchedulerOptions::settle.
  Time settled_at{};
  LeaseTable leases;
  std::vector<std::string> hosts_by_number;
  absl::flat_hash_map<std::string, HostNumber> host_numbers;
  std::map<std::string, std::string> distrusted;  // host or identity -> why
  std::vector<FarmEvent> events;
};

}  // namespace tessera::server
