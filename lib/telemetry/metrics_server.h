// The port that Prometheus asks.
#pragma once

#include <prometheus/collectable.h>

#include <cstddef>
#include <list>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "telemetry/http_daemon.h"

struct MHD_Connection;

namespace tessera::telemetry {

/// Serves /metrics over plain HTTP, from one thread.
class MetricsServer {
 public:
  /// Connections at once. Beyond half of them the oldest is closed: a scrape is over in milliseconds.
  static constexpr std::size_t kMostConnections = 128;

  /// Unavailable where `address` (HOST:PORT; port 0 takes a free one) cannot be listened on.
  static absl::StatusOr<std::unique_ptr<MetricsServer>> start(
      const std::string& address, std::vector<std::shared_ptr<prometheus::Collectable>> sources);
  MetricsServer(const MetricsServer&) = delete;
  MetricsServer& operator=(const MetricsServer&) = delete;

  int port() const;

 private:
  struct Callbacks;  // functions that libmicrohttpd calls

  MetricsServer() = default;
  std::string text() const;
  void opened(MHD_Connection* connection);

  std::vector<std::shared_ptr<prometheus::Collectable>> sources_;
  std::list<MHD_Connection*> connections_;  // the oldest first; for the daemon's thread only
  HttpDaemon daemon_;                       // calls this object: goes first
};

}  // namespace tessera::telemetry
