// A whole farm on one virtual clock: the coordinator, workers and clients as they are, with all their
// threads; a renderer that paints, a network that loses and delays, machines that die. Everything follows
// from the seed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "agent/agent.h"
#include "scenario/whole_farm/chance.h"
#include "scenario/whole_farm/mortal_coordinator.h"
#include "scenario/whole_farm/rough_link.h"
#include "support/process/temp_dir.h"
#include "support/sequencer.h"
#include "tessera/v1/farm.pb.h"

namespace tessera::test {

/// Counts of events, for tests that want to know that something happened.
struct FarmWorldCounts {
  std::uint64_t turns = 0, results = 0, mishaps = 0, coordinator_deaths = 0, worker_deaths = 0, drained = 0,
                failed_units = 0, cancelled = 0, reopened = 0, submitted_again = 0, caches = 0, phases = 0;
  std::chrono::milliseconds time{0};  // the world's
};

class FarmWorld {
 public:
  /// `replay`: the command that runs this seed again.
  FarmWorld(std::uint64_t seed, std::string replay);
  ~FarmWorld();

  /// Chaos for a while, then peace until every job has ended. Returns the first thing that does not hold, in
  /// words; empty when all do.
  std::string run();

  const FarmWorldCounts& counts() const { return counts_; }
  /// Tells one course of events from another.
  std::uint64_t digest() const { return clock_.digest(); }

 private:
  struct Machine {
    std::string name;
    int threads = 1;
    std::uint64_t rounding = 0;   // its arithmetic class
    std::filesystem::path cache;  // empty: it reads blobs from the coordinator's memory
    std::shared_ptr<bool> cut;
    std::unique_ptr<agent::Agent> agent;  // null while it is dead
    base::Thread runner;
  };
  /// A job, and the client who waits for it.
  struct Order {
    std::string request_id;
    v1::JobSpec spec;
    std::chrono::milliseconds begin{0};
    std::optional<std::chrono::milliseconds> cancelled_after;
    bool cancels = false;                            // the cancellation was asked for
    std::string id;                                  // once it is acknowledged
    v1::JobState state = v1::JOB_STATE_UNSPECIFIED;  // in which it ended
    std::string error;
    std::vector<v1::UnitResult> results;
  };

  server::FarmOptions draw_farm();
  void draw_network();
  void draw_machines();
  void draw_orders();
  void violate(const std::string& what);

  // ---- machines
  void start(Machine& machine);
  void kill(Machine& machine);
  /// It finishes what it has begun.
  void drain(Machine& machine);
  /// Work of a unit: how long it takes, and whether it comes to an end.
  absl::Status work(const std::stop_token& stop);
  /// Whether something else succeeds.
  absl::Status try_luck();
  void bring_mishap();

  // ---- clients, each on a thread of its own
  void order_picture(Order& order, const std::stop_token& stop);
  /// To its end, and beyond where something is missing.
  void follow(Order& order, const std::stop_token& stop);
  void cancel(Order& order, const std::stop_token& stop);
  /// Makes the call until it is answered, over all deaths of the coordinator. Cancelled when `stop` is
  /// requested.
  template <class Call>
  auto insist(const std::stop_token& stop, const Call& call);

  bool all_over() const;
  void check_results(const Order& order);
  /// Leftovers where nothing should be; empty where nothing is.
  std::string leftovers();

  Sequencer clock_;
  Chance chance_;
  // Properties of this seed's world.
  double failing_ = 0, hanging_ = 0;
  std::chrono::milliseconds longest_unit_{0}, unit_limit_{0}, chaos_{0};

  std::optional<support::TempDir> caches_;
  std::optional<MortalCoordinator> coordinator_;
  std::optional<Network> network_;
  std::vector<Machine> machines_;
  std::vector<Order> orders_;
  std::mutex mutex_;
  base::Condition progress_{clock_};
  std::string violation_;
  FarmWorldCounts counts_;
};

}  // namespace tessera::test
