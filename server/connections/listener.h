// A listening port, and the thread that accepts for gRPC. gRPC 1.51 stops listening for good when it finds no
// free descriptor, tells nobody who is connecting, and takes connections without a bound.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "base/address.h"
#include "connections/connections.h"

namespace grpc::experimental {
class ExternalConnectionAcceptor;
}

namespace tessera::server {

/// Listens from open() on, accepts from start() on, and never stops by itself: a socket that fails is opened
/// anew.
class Listener {
 public:
  using Acceptor = std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor>;

  /// Unavailable where the address is not one of this machine, or in use. `connections` must outlive the
  /// listener.
  static absl::StatusOr<std::unique_ptr<Listener>> open(const base::HostPort& address,
                                                        Connections& connections, Connections::Port kind);
  /// Stops, as stop() does.
  ~Listener();

  int port() const { return address_.port; }

  /// Once the server runs.
  void start(Acceptor acceptor);
  /// Listens no more. Before the server is shut down: later it would take what is accepted, and forget it.
  void stop();

 private:
  Listener(base::HostPort address, Connections& connections, Connections::Port kind);

  absl::Status listen();
  void run();
  void accept_waiting(int socket);
  /// False where the socket is of no more use.
  bool bear(int error, int socket);
  void hand_over(int connection, int socket);
  void close_sockets();

  base::HostPort address_;  // The port is the one that was taken.
  Connections& connections_;
  const Connections::Port kind_;
  Acceptor acceptor_;
  std::vector<int> sockets_;
  int wake_ = -1;   // an eventfd
  int spare_ = -1;  // given up to accept, and close, what comes when there is no other descriptor
  telemetry::LineLimit exhausted_;
  std::atomic<bool> broken_ = false, stopping_ = false;
  std::thread thread_;
};

}  // namespace tessera::server
