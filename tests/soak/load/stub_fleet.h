// Thousands of workers that render nothing: they speak to the coordinator as real ones do, over few
// connections.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "soak/load/latency_histogram.h"
#include "soak/load/timers.h"
#include "tessera/v1/job.pb.h"

namespace tessera::load {

struct FleetOptions {
  std::size_t workers = 100;
  std::size_t workers_per_connection = 250;
  std::uint32_t threads_per_worker = 8;
  std::chrono::milliseconds unit_time{0};  // mean on one thread
  std::size_t scenes_per_worker = 2;
};

/// Counts of all that was done. Thread-safe.
struct FleetTally {
  std::atomic<std::uint64_t> completed{0};  // acknowledged as durable
  std::atomic<std::uint64_t> refused{0};    // results that were not accepted, and never will be
  std::atomic<std::uint64_t> heartbeats{0};
  std::atomic<std::uint64_t> revoked{0};  // leases
  std::atomic<std::uint64_t> retries{0};  // calls that were tried again
  std::atomic<std::uint64_t> leased{0};   // units
  LatencyHistogram lease;                 // time that workers with nothing to do waited for units
  LatencyHistogram complete;
  LatencyHistogram heartbeat;
};

/// The result of a unit: the same bytes whoever returns it. Its pixels are as random as rendered ones are, so
/// that it compresses as badly.
std::string stub_result(const v1::WorkUnit& unit);

/// Statistics of a unit, as large as those of real workers.
v1::UnitStats stub_stats(std::chrono::milliseconds unit_time);

class StubFleet {
 public:
  /// Told of each acknowledged result, from any thread.
  using Completed = std::function<void(const std::string& job, std::uint32_t unit)>;

  StubFleet(std::string address, const FleetOptions& options, Completed completed);
  /// Ends all calls, and waits for that.
  ~StubFleet();
  StubFleet(const StubFleet&) = delete;
  StubFleet& operator=(const StubFleet&) = delete;

  /// Begins to register all workers; each works from then on, over restarts of the coordinator.
  void start();
  /// Workers that the coordinator has given a name.
  std::size_t registered() const { return registered_; }

  const FleetTally& tally() const { return tally_; }
  /// How long calls took is counted from now on.
  void clear_latencies();

 private:
  class Worker;

  const FleetOptions options_;
  const Completed completed_;
  FleetTally tally_;
  std::atomic<std::size_t> registered_{0};
  std::atomic<bool> stopping_{false};
  std::atomic<std::size_t> calls_{0};  // under way
  Timers timers_;
  std::vector<std::unique_ptr<Worker>> workers_;
};

}  // namespace tessera::load
