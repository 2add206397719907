// What the coordinator counts, for Prometheus.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/statusor.h"

namespace prometheus {
class Collectable;
class Exposer;
}  // namespace prometheus

namespace tessera::server {

class Farm;

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

/// Serves /metrics over HTTP: the farm's counters, and gauges of its jobs, units and workers as they are when asked
/// for.
class MetricsServer {
 public:
  /// Unavailable where `address` (HOST:PORT) cannot be listened on. The farm must outlive the server.
  static absl::StatusOr<std::unique_ptr<MetricsServer>> start(const std::string& address, Farm& farm);
  ~MetricsServer();

  int port() const;

 private:
  MetricsServer() = default;
  std::shared_ptr<prometheus::Collectable> gauges_;
  std::unique_ptr<prometheus::Exposer> exposer_;
};

}  // namespace tessera::server
