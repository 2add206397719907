// Counts of the coordinator, for Prometheus.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>

namespace prometheus {
class Collectable;
}  // namespace prometheus

namespace tessera::server {

class Connections;
class Farm;
class OpenStreams;

/// Counters and histograms, added to as things happen. Thread-safe.
class FarmMetrics {
 public:
  FarmMetrics();
  ~FarmMetrics();

  /// Calls that go through the scheduler's lock.
  enum class Call { kLease, kHeartbeat, kComplete, kFail, kTick, kCount };
  void served(Call call, std::chrono::nanoseconds taken);
  void leased(std::uint64_t units);
  void completed(std::chrono::nanoseconds unit_time, std::uint64_t bytes);
  void repeated();  // a result that was there already
  void refused();   // a result that was not accepted
  void failed();    // a unit that a worker could not render
  void lost(std::uint64_t leases);
  void committed(std::chrono::nanoseconds taken, std::uint64_t entries);
  void uploaded(std::uint64_t bytes);

  std::shared_ptr<prometheus::Collectable> collectable() const;

 private:
  struct Series;
  std::unique_ptr<Series> series_;
};

/// Gauges of the farm's jobs, units and workers as they are when asked for. The farm must outlive them.
std::shared_ptr<prometheus::Collectable> farm_gauges(Farm& farm);
/// How many streams were cut off. They must outlive it.
std::shared_ptr<prometheus::Collectable> stream_counter(const OpenStreams& streams);
/// Connections that are open, were refused, or closed because nothing came on them. They must outlive it.
std::shared_ptr<prometheus::Collectable> connection_metrics(const Connections& connections);

}  // namespace tessera::server
