// The port that Prometheus asks.
#pragma once

#include <prometheus/collectable.h>

#include <cstddef>
#include <list>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

struct MHD_Connection;
struct MHD_Daemon;
struct sockaddr;

namespace tessera::telemetry {

/// Serves /metrics over plain HTTP, from one thread.
class MetricsServer {
 public:
  /// Connections at once. Beyond half of them the oldest is closed: a scrape is over in milliseconds.
  static constexpr std::size_t kMostConnections = 128;

  /// Unavailable where `address` (HOST:PORT; port 0 takes a free one) cannot be listened on.
  static absl::StatusOr<std::unique_ptr<MetricsServer>> start(
      const std::string& address, std::vector<std::shared_ptr<prometheus::Collectable>> sources);
  ~MetricsServer();
  MetricsServer(const MetricsServer&) = delete;
  MetricsServer& operator=(const MetricsServer&) = delete;

  int port() const;

 private:
  struct Callbacks;  // of libmicrohttpd

  MetricsServer() = default;
  bool listen(const sockaddr& address);
  std::string text() const;
  void opened(MHD_Connection* connection);

  std::vector<std::shared_ptr<prometheus::Collectable>> sources_;
  std::list<MHD_Connection*> connections_;  // the oldest first; for the daemon's thread only
  MHD_Daemon* daemon_ = nullptr;
};

}  // namespace tessera::telemetry
