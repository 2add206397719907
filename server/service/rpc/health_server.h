// Health for probes that have no certificate.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "connections/listener.h"

namespace tessera::server {

/// Serves grpc.health.v1.Health, and nothing else, without encryption on a port of its own: Kubernetes' gRPC
/// probes know no certificates. NOT_SERVING until set_serving(true).
class HealthServer {
 public:
  /// `address` is HOST:PORT; port 0 takes a free one. InvalidArgument where it is malformed, Unavailable
  /// where it cannot be listened on. `connections` must outlive the server.
  static absl::StatusOr<std::unique_ptr<HealthServer>> start(const std::string& address,
                                                             Connections& connections);
  ~HealthServer();

  void set_serving(bool serving);
  int port() const { return listener_->port(); }

 private:
  HealthServer() = default;
  std::unique_ptr<grpc::Server> server_;
  std::unique_ptr<Listener> listener_;
};

}  // namespace tessera::server
