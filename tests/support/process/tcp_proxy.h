// A network between two programs that fails on command.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <thread>
#include <vector>

namespace tessera::support {

/// Forwards TCP connections on a free port of loopback to another port there. Thread-safe.
class TcpProxy {
 public:
  enum class Fault {
    kNone,
    kSilence,   // nothing is forwarded, nothing is closed: as when packets are lost both ways
    kDeaf,      // bytes from the clients are not forwarded; those from the server are
    kMute,      // bytes from the server are not forwarded; those from the clients are
    kRefusing,  // connections are closed, new ones at once
  };

  /// Throws std::system_error when there is no free port.
  explicit TcpProxy(int server_port);
  ~TcpProxy();
  TcpProxy(const TcpProxy&) = delete;
  TcpProxy& operator=(const TcpProxy&) = delete;

  /// "127.0.0.1:PORT", for clients.
  std::string address() const;

  /// From now on. What a fault held back is forwarded when it is over, as TCP would send it again.
  void set_fault(Fault fault) { fault_ = fault; }

  /// Flips one bit in about `bytes` bytes that are forwarded from now on; 0: none.
  void flip_a_bit_in(std::uint64_t bytes) { flip_every_ = bytes; }
  std::uint64_t flipped() const { return flipped_; }

  /// Forwards at most so many bytes of what each client sends, and nothing more of it; to be said before they
  /// connect.
  void forward_at_most(std::uint64_t bytes_of_client) { most_of_client_ = bytes_of_client; }
  /// Bytes of clients that were forwarded, of all connections.
  std::uint64_t forwarded() const { return forwarded_; }

 private:
  void accept_all(std::stop_token stop);
  void forward(int client, std::uint64_t number, std::stop_token stop);
  /// Bytes passed on; 0 when the connection is over.
  std::size_t pass(int from, int to, std::uint64_t& random);

  const int server_port_;
  int listener_ = -1;
  int port_ = 0;
  std::atomic<Fault> fault_{Fault::kNone};
  std::atomic<std::uint64_t> flip_every_{0}, flipped_{0};
  std::atomic<std::uint64_t> most_of_client_{std::numeric_limits<std::uint64_t>::max()}, forwarded_{0};
  std::vector<std::jthread> connections_;
  std::jthread accepting_;
};

}  // namespace tessera::support
