// Health for probes that have no certificate.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>

#include "absl/status/statusor.h"

namespace tessera::server {

/// Serves grpc.health.v1.Health, and nothing else, without encryption on a port of its own: Kubernetes' gRPC probes
/// know no certificates. NOT_SERVING until set_serving(true).
class HealthServer {
 public:
  /// `address` is HOST:PORT; port 0 takes a free one. InvalidArgument where it is malformed, Unavailable where it
  /// cannot be listened on.
  static absl::StatusOr<std::unique_ptr<HealthServer>> start(const std::string& address);
  ~HealthServer();

  void set_serving(bool serving);
  int port() const { return port_; }

 private:
  HealthServer() = default;
  std::unique_ptr<grpc::Server> server_;
  int port_ = 0;
};

}  // namespace tessera::server
