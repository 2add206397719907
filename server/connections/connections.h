// The coordinator's open connections: who has how many, and which of them have not said anything yet.
#pragma once

#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/types.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <list>
#include <mutex>
#include <string>
#include <string_view>
#include <unordered_map>

#include "telemetry/line_limit.h"

namespace tessera::server {

/// An address and a port, IPv4 and IPv6 alike.
struct Peer {
  in6_addr address{};  // IPv4 mapped into IPv6
  std::uint16_t port = 0;

  static Peer of(const sockaddr_storage& socket_address);
  /// Reads gRPC's name of a peer: "ipv4:10.0.0.1:4711", "ipv6:%5B::1%5D:4711". Port 0 where it is something
  /// else.
  static Peer of(std::string_view grpc_peer);

  /// The same for all that one owner of an address may have: an IPv6 network of 64 bits counts as one
  /// address.
  Peer owner() const;
  /// "10.0.0.1:4711".
  std::string to_string() const;
  friend bool operator==(const Peer& a, const Peer& b);
};

/// Upper bounds of connections that are open at the same time.
struct ConnectionLimits {
  std::size_t all = 1024;
  std::size_t of_address = 768;
  /// Connections on which no call has come yet: nobody knows who that is.
  std::size_t silent = 512;
  std::size_t silent_of_address = 256;
  std::chrono::milliseconds silence{20'000};  // then they are closed
  /// Where there are too many of them, the oldest goes once it has had this time for its handshake.
  std::chrono::milliseconds handshake{1'000};

  /// Three quarters for one address, which may be that of a whole farm behind a router or on one machine.
  static ConnectionLimits within(std::size_t connections);
};

/// gRPC owns the descriptors, and closes them without telling. A record knows its descriptor by number and
/// inode, so that what has become of it can be looked up. Thread-safe.
class Connections {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Connections(const ConnectionLimits& limits) : limits_(limits) {}

  enum class Port {
    kMembers,    // a call shows that somebody was let in
    kStrangers,  // everybody may call: no connection is ever more than silent
    kBrowsers,   // members who fall silent between their calls; nothing is told of ends that are usual
  };
  /// Whether this connection, just accepted, may be handed to gRPC. Others may be closed for it.
  bool admit(int descriptor, const Peer& peer, Port port, Clock::time_point now);
  /// A call came from there.
  void spoke(const Peer& peer);
  /// The call is over: the next one has to come in time, like the first.
  void fell_silent(const Peer& peer, Clock::time_point now);
  /// Forgets what gRPC has closed, and closes what was silent for too long. To be called every second or so.
  void sweep(Clock::time_point now);

  std::size_t open() const { return open_; }
  std::size_t silent() const { return silent_count_; }
  std::uint64_t taken() const { return taken_; }
  std::uint64_t refused() const { return refused_; }
  /// That were closed because no call came.
  std::uint64_t closed() const { return closed_; }
  const ConnectionLimits& limits() const { return limits_; }

 private:
  struct Hash {
    std::size_t operator()(const Peer& peer) const;
  };
  struct Record;
  using Records = std::list<Record>;
  struct Owner {
    std::size_t open = 0;
    std::list<Records::iterator> silent;  // the oldest first
  };
  struct Record {
    int descriptor;
    ino_t inode;
    Peer peer;
    Port port;
    Clock::time_point since;
    bool is_silent = true;
    bool is_closed_here = false;  // gRPC has yet to notice
    std::list<Records::iterator>::iterator silent_place = {}, silent_of_owner = {};
  };

  // All with mutex_ held.
  bool make_room(const Peer& owner, Clock::time_point now);
  bool close_oldest(const std::list<Records::iterator>& silent, Clock::time_point now);
  void close(Record& record);
  void mark_silent(Records::iterator record);
  void unmark_silent(Record& record);
  void forget(Records::iterator record);
  void refuse(const Peer& peer, const char* why);
  /// Looks at the next `count` records, from where it stopped.
  void sweep_some(std::size_t count, Clock::time_point now);

  const ConnectionLimits limits_;
  std::mutex mutex_;
  Records records_;
  Records::iterator next_to_sweep_ = records_.end();
  std::list<Records::iterator> silent_;  // the oldest first
  std::unordered_map<Peer, Owner, Hash> owners_;
  std::unordered_multimap<Peer, Records::iterator, Hash> by_peer_;
  std::atomic<std::size_t> open_ = 0, silent_count_ = 0;
  std::atomic<std::uint64_t> taken_ = 0, refused_ = 0, closed_ = 0;
  telemetry::LineLimit refusals_, endings_;
};

}  // namespace tessera::server
