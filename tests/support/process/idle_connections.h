// Connections on which nobody says anything.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace tessera::support {

/// To one address (HOST:PORT, the host a number), from loopback. All are closed in the end, in a way that
/// leaves nothing behind in the system.
class IdleConnections {
 public:
  explicit IdleConnections(const std::string& address);
  ~IdleConnections() { close_all(); }
  IdleConnections(const IdleConnections&) = delete;
  IdleConnections& operator=(const IdleConnections&) = delete;

  /// Begins so many more; does not wait for them. Throws std::system_error where this process has no
  /// descriptors left.
  void open(std::size_t count);
  void close_all();
  std::size_t size() const { return sockets_.size(); }

 private:
  std::string host_;
  int port_ = 0;
  std::vector<int> sockets_;
};

}  // namespace tessera::support
