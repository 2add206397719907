// Who may have how many connections, and what becomes of those that say nothing.
#include "connections/connections.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <list>
#include <string>

#include "connections/descriptors.h"

namespace tessera::server {
namespace {

using std::chrono::milliseconds;
using Port = Connections::Port;

Peer peer(const std::string& host, std::uint16_t port) {
  sockaddr_storage address{};
  if (host.find(':') != std::string::npos) {
    auto& v6 = reinterpret_cast<sockaddr_in6&>(address);
    v6.sin6_family = AF_INET6;
    v6.sin6_port = htons(port);
    EXPECT_EQ(::inet_pton(AF_INET6, host.c_str(), &v6.sin6_addr), 1);
  } else {
    auto& v4 = reinterpret_cast<sockaddr_in&>(address);
    v4.sin_family = AF_INET;
    v4.sin_port = htons(port);
    EXPECT_EQ(::inet_pton(AF_INET, host.c_str(), &v4.sin_addr), 1);
  }
  return Peer::of(address);
}

/// A connection as an accept loop has it, and its other end.
struct Pair {
  Pair() {
    int ends[2];
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    mine = ends[0];
    other = ends[1];
  }
  ~Pair() {
    hang_up();
    ::close(other);
  }
  /// Closes it like gRPC does when a connection is over.
  void hang_up() {
    if (mine >= 0) ::close(mine);
    mine = -1;
  }
  bool is_shut() const {
    pollfd end{.fd = other, .events = POLLIN, .revents = 0};
    return ::poll(&end, 1, 0) == 1;
  }
  int mine = -1, other = -1;
};

class ConnectionsTest : public testing::Test {
 protected:
  static constexpr ConnectionLimits kLimits{.all = 8, .of_address = 6, .silent = 5, .silent_of_address = 3};

  Pair& connect(const std::string& host, Port port = Port::kMembers) {
    pairs_.emplace_back();
    admitted_ = connections_.admit(pairs_.back().mine, peer(host, ++port_), port, now_);
    return pairs_.back();
  }
  Pair& member(const std::string& host) {
    Pair& pair = connect(host);
    connections_.spoke(peer(host, port_));
    return pair;
  }

  Connections connections_{kLimits};
  Connections::Clock::time_point now_{std::chrono::hours{1}};
  std::list<Pair> pairs_;
  std::uint16_t port_ = 0;
  bool admitted_ = false;
};

TEST_F(ConnectionsTest, SilentOnesOfAnAddressAreBoundedAndTheOldestGoes) {
  Pair& first = connect("10.0.0.1");
  connect("10.0.0.1");
  connect("10.0.0.1");
  connect("10.0.0.1");
  EXPECT_FALSE(admitted_) << "each has time for its handshake";
  EXPECT_FALSE(first.is_shut());
  connect("10.0.0.2");
  EXPECT_TRUE(admitted_) << "others do not suffer";
  now_ += kLimits.handshake;
  connect("10.0.0.1");
  EXPECT_TRUE(admitted_);
  EXPECT_TRUE(first.is_shut());
  EXPECT_EQ(connections_.silent(), 4u);
  EXPECT_EQ(connections_.refused(), 1u);
  EXPECT_EQ(connections_.closed(), 1u);
}

TEST_F(ConnectionsTest, SilentOnesOfAllAddressesAreBoundedTogether) {
  Pair& first = connect("10.0.0.1");
  for (int i = 2; i <= 5; ++i) connect("10.0.0." + std::to_string(i));
  now_ += kLimits.handshake;
  connect("10.0.0.6");
  EXPECT_TRUE(admitted_);
  EXPECT_TRUE(first.is_shut());
  EXPECT_EQ(connections_.silent(), 5u);
}

TEST_F(ConnectionsTest, AMemberStaysWhateverStrangersDo) {
  Pair& worker = member("10.0.0.1");
  for (int i = 0; i < 20; ++i) {
    connect("10.0.0.1");
    now_ += kLimits.handshake;
  }
  EXPECT_FALSE(worker.is_shut());
  now_ += kLimits.silence;
  connections_.sweep(now_);
  EXPECT_FALSE(worker.is_shut());
  EXPECT_EQ(connections_.silent(), 0u);
}

TEST_F(ConnectionsTest, AnAddressHasAPartOfAllAndOthersTheRest) {
  for (int i = 0; i < 6; ++i) member("10.0.0.1");
  EXPECT_TRUE(admitted_);
  connect("10.0.0.1");
  EXPECT_FALSE(admitted_);
  member("10.0.0.2");
  member("10.0.0.3");
  EXPECT_TRUE(admitted_);
  connect("10.0.0.4");
  EXPECT_FALSE(admitted_) << "8 are all";
  EXPECT_EQ(connections_.open(), 8u);
}

TEST_F(ConnectionsTest, RoomComesBackWhenConnectionsEnd) {
  for (int i = 0; i < 6; ++i) member("10.0.0.1");
  pairs_.front().hang_up();
  connect("10.0.0.1");
  EXPECT_TRUE(admitted_);
  for (Pair& pair : pairs_) pair.hang_up();
  connections_.sweep(now_);
  EXPECT_EQ(connections_.open(), 0u);
  EXPECT_EQ(connections_.silent(), 0u);
}

TEST_F(ConnectionsTest, WhoeverSaysNothingIsClosedInTime) {
  Pair& stranger = connect("10.0.0.1");
  now_ += kLimits.silence - milliseconds{1};
  connections_.sweep(now_);
  EXPECT_FALSE(stranger.is_shut());
  now_ += milliseconds{1};
  connections_.sweep(now_);
  EXPECT_TRUE(stranger.is_shut());
}

TEST_F(ConnectionsTest, WhereEverybodyMayCallACallChangesNothing) {
  Pair& stranger = connect("10.0.0.1", Port::kStrangers);
  connections_.spoke(peer("10.0.0.1", port_));
  now_ += kLimits.silence;
  connections_.sweep(now_);
  EXPECT_TRUE(stranger.is_shut());
}

TEST_F(ConnectionsTest, ADescriptorThatIsAnotherConnectionByNowIsLeftAlone) {
  Pair& stranger = connect("10.0.0.1");
  Pair innocent;
  ASSERT_EQ(::dup2(innocent.mine, stranger.mine), stranger.mine);
  now_ += kLimits.silence;
  connections_.sweep(now_);
  EXPECT_FALSE(innocent.is_shut());
  EXPECT_EQ(connections_.open(), 0u);
}

TEST_F(ConnectionsTest, ANetworkOfIpv6CountsAsOneAddress) {
  for (int i = 1; i <= 3; ++i) connect("2001:db8:1:1::" + std::to_string(i));
  connect("2001:db8:1:1:ffff::1");
  EXPECT_FALSE(admitted_);
  connect("2001:db8:1:2::1");
  EXPECT_TRUE(admitted_);
}

TEST(Peer, IsReadAsGrpcWritesIt) {
  EXPECT_EQ(Peer::of("ipv4:10.0.0.1:4711"), peer("10.0.0.1", 4711));
  EXPECT_EQ(Peer::of("ipv6:%5B2001:db8::1%5D:4711"), peer("2001:db8::1", 4711));
  EXPECT_EQ(Peer::of("ipv6:%5B::1%5D:80"), peer("::1", 80));
  EXPECT_EQ(peer("10.0.0.1", 4711).to_string(), "10.0.0.1:4711");
  EXPECT_EQ(peer("2001:db8::1", 4711).to_string(), "[2001:db8::1]:4711");
  for (const char* odd :
       {"", "unix:", "fd:7", "ipv4:", "ipv4:10.0.0.1", "ipv4:10.0.0.1:x", "ipv6:%5B::1", "ipv4:a:1"}) {
    EXPECT_EQ(Peer::of(odd).port, 0) << odd;
  }
}

TEST(Descriptors, SomeAreKeptBackAndNoLimitIsTooSmall) {
  EXPECT_EQ(connections_within(1024), 1024u - 256);
  EXPECT_EQ(connections_within(20'000), 20'000u - 512);
  EXPECT_EQ(connections_within(1'000'000), kMostConnections);
  EXPECT_EQ(connections_within(256), 256u - 64);
  EXPECT_EQ(connections_within(10), 0u);
}

}  // namespace
}  // namespace tessera::server
