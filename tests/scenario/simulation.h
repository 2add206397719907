// A farm of many machines in one thread: the real scheduler and journal, a network that delays, drops,
// doubles and reorders, workers that crash, hang, slow down, lie and return late, and a coordinator that dies
// between any two steps. Everything follows from the seed.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "scenario/model_journal.h"
#include "scenario/simulated_coordinator.h"
#include "scenario/simulated_disk.h"
#include "scenario/trace.h"

namespace tessera::server {

struct SimulationOptions {
  std::uint64_t seed = 0;
  /// SQLite and result files on a disk whose power fails; else the model of it, which is a hundred times
  /// faster.
  bool real_journal = false;
  std::size_t workers = 0;  // 0: as the seed says, up to ten
};

/// Counts of events, for tests that want to know that something happened.
struct SimulationCounts {
  std::uint64_t steps = 0, results = 0, coordinator_deaths = 0, worker_deaths = 0, power_failures = 0,
                set_aside = 0, quarantines = 0, revoked = 0, disk_full = 0, adopted = 0, audits = 0, runs = 0,
                made = 0;  // results of phases
};

class Simulation {
 public:
  explicit Simulation(const SimulationOptions& options);
  ~Simulation();

  /// Chaos for some simulated minutes, then honest work until every job has ended. The first invariant that
  /// does not hold, in words; empty when all do.
  std::string run();
  const SimulationCounts& counts() const { return counts_; }
  /// Tells one course of events from another: what was journaled, leased and revoked, in order.
  std::uint64_t trace() const { return trace_.digest(); }

 private:
  // Promises, and to whom they were made.
  struct Promise {
    JobRequest request;
    std::string donor;    // a job of the same content that it continues; empty: none
    std::string content;  // honest results follow from it: equal for such jobs
    std::vector<std::uint32_t> phase_parts;
    bool acknowledged = false;  // the submission
    bool cancel_acknowledged = false;
    struct Result {
      CoveredUnits units;
      std::string digest;
      std::string host;
      std::uint64_t inputs = 0;  // hash of the inputs that it was made of (LeaseToken.inputs)
      bool acknowledged = false;
      bool revoked = false;
      std::uint32_t audits = 0;         // journaled audits
      std::uint32_t second_leases = 0;  // given out after it was acknowledged
      bool disputed = false;            // hosts disagree on it
    };
    std::vector<Result> journaled;                   // results in the order of their sequence numbers
    std::map<std::uint32_t, std::size_t> live;       // unit -> index into `journaled`
    v1::JobState ended = v1::JOB_STATE_UNSPECIFIED;  // journaled state
    bool journaled_job = false;
    std::uint64_t arrived = 0;  // when that was, in the order of jobs
    bool failed = false;        // a unit of it was not rendered, once
    // Class of its results that count, if they are to be of one; empty: not known yet.
    std::string arithmetic_class;
  };
  struct Held {
    v1::LeaseToken token;
    std::string arithmetic_class;  // class of its rendering
    Time done_at{};
    Time cost{};
    bool sent = false;
  };
  struct Worker {
    std::string host;
    std::vector<std::string> classes;  // arithmetic, best first
    std::string id;                    // given at registration; empty: not registered
    bool alive = true;
    bool liar = false;
    double slowness = 1;
    Time hangs_until{};
    std::uint32_t threads = 1;
    std::vector<Held> held;
    std::uint64_t life = 0;  // one more after each death
  };

  using Step = std::function<void()>;
  std::uint64_t pick(std::uint64_t below) { return random_() % below; }
  bool chance(double probability) { return static_cast<double>(random_() % 1'000'000) < probability * 1e6; }
  void at(Time time, Step step);
  void violate(const std::string& what);

  // ---- the network
  /// Delivers `message` to the coordinator: late, twice or never, if it lives then.
  void to_coordinator(Step message);
  void to_worker(std::size_t worker, Step message);

  // ---- the coordinator
  void start_coordinator();
  void kill_coordinator();
  void beat_coordinator();
  void commit();
  void learn(const std::vector<JournalEntry>& entries);
  void learn(const UnitDone& done);
  /// All that one commit made durable.
  void learn_group(const std::vector<JournalEntry>& entries);
  std::optional<std::uint64_t> inputs_of(const Promise& promise, std::uint32_t unit) const;
  void check_inputs();
  /// Whether a commit in which the power failed is there; it must be there whole or not at all.
  void resolve_doubt(const std::map<std::string, JobRecord>& records);
  void check_recovery(const std::map<std::string, JobRecord>& records);
  void check();

  // ---- workers (simulated_workers.cpp)
  void start_worker(std::size_t index);
  void work(std::size_t index);
  void register_worker(std::size_t index);
  void ask_for_units(std::size_t index);
  /// `isas` are those of the kernels with which the decision's units are to be rendered.
  void receive_units(std::size_t index, const LeaseDecision& decision, const std::vector<std::string>& isas);
  static std::string class_of(const Worker& worker, const std::string& isa);
  void deliver(std::size_t index, const Held& held);
  void forget(Worker& worker, const v1::LeaseToken& token);
  void kill_worker(std::size_t index);
  UnitRun units_of(const std::string& job, const CoveredUnits& covered) const;
  UnitRun units_of(const v1::LeaseToken& token) const { return units_of(token.job_id(), covered_by(token)); }
  bool poisonous(const v1::LeaseToken& token) const;
  /// Fingerprint that an honest worker returns.
  ResultFingerprint truth_of(const Promise& promise, const CoveredUnits& units,
                             const std::string& arithmetic_class, std::uint64_t inputs) const;
  void check_class(Promise& promise, const UnitDone& done, std::uint64_t inputs);
  void check_grant(const Worker& worker, const v1::LeaseToken& token);
  /// How many units each job has waiting.
  std::map<std::string, std::uint32_t> waiting_units(const std::string& worker) const;
  void check_order(const Worker& worker, const LeaseDecision& decision,
                   const std::map<std::string, std::uint32_t>& waited);
  void check_sent_away(const Worker& worker, const std::string& id,
                       const std::map<std::string, std::uint32_t>& waited);
  bool is_usual_pace_common() const;
  void check_paces();
  /// Time of a unit on a usual thread: log-normal over two decades, and a
  /// ray's part of it by a third.
  struct Effort {
    double milliseconds = 0;
    std::uint64_t rays = 0;
  };
  Effort effort_of(const v1::LeaseToken& token) const;

  // ---- clients (simulated_clients.cpp)
  void submit_job();
  void ask_for_job(const std::string& id);
  void meddle();
  bool all_ended() const;

  const SimulationOptions options_;
  std::mt19937_64 random_;
  Time now_{0};
  bool chaos_ = true;
  std::string violation_;
  SimulationCounts counts_;
  Trace trace_;
  // Those of one time are in the order in which they were made.
  std::map<std::pair<Time, std::uint64_t>, Step> events_by_time_;
  std::uint64_t order_ = 0;

  // Properties of this seed's world.
  double drop_ = 0, twice_ = 0, worker_death_ = 0, coordinator_death_ = 0, fail_ = 0;
  Time longest_delay_{1};
  Time settle_{0};
  bool usual_pace_is_common_ = false;
  bool audits_ = false, liars_ = false, poison_ = false, full_disk_ = false;
  bool runs_ = false;  // units are leased in runs as often as there can be
  bool phases_ = false;
  JobOrder job_order_ = JobOrder::kFirstCome;

  std::unique_ptr<SimulatedDisk> disk_;
  ModelJournal model_;
  std::unique_ptr<Journal> real_;
  SimulatedCoordinator::Jobs jobs_;
  std::unique_ptr<SimulatedCoordinator> coordinator_;
  std::uint64_t incarnation_ = 0;
  bool committing_ = false;
  std::vector<JournalEntry> in_doubt_;
  std::uint64_t names_ = 0, arrivals_ = 0;
  std::map<std::string, Promise> promises_;
  std::vector<Worker> workers_;
};

}  // namespace tessera::server
