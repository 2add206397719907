// A coordinator on a port of its own, whose listening socket and strangers misbehave.
#include "connections/listener.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <string>
#include <thread>

#include "net/channel.h"
#include "support/patience.h"
#include "unit/server/coordinator_fixture.h"

namespace tessera::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class ListenerTest : public CoordinatorTest {
 protected:
  CoordinatorOptions options(const std::string& listen) const {
    CoordinatorOptions options;
    options.listen = listen;
    return options;
  }

  /// Somebody who was never there before.
  grpc::Status list_jobs(const std::string& host) const {
    grpc::ChannelArguments arguments = net::channel_arguments();
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    const auto stub = v1::FarmService::NewStub(
        grpc::CreateCustomChannel(host + ":" + std::to_string(coordinator_->bound_port()),
                                  grpc::InsecureChannelCredentials(), arguments));
    grpc::ClientContext context;
    context.set_wait_for_ready(true);
    context.set_deadline(std::chrono::system_clock::now() + support::kPatience);
    v1::ListJobsResponse response;
    return stub->ListJobs(&context, {}, &response);
  }

  /// This process's sockets that listen on the coordinator's port.
  std::vector<int> listening_sockets() const {
    std::vector<int> sockets;
    for (int descriptor = 0; descriptor < 1024; ++descriptor) {
      int listens = 0;
      socklen_t size = sizeof(listens);
      if (::getsockopt(descriptor, SOL_SOCKET, SO_ACCEPTCONN, &listens, &size) != 0 || listens == 0) continue;
      sockaddr_storage address{};
      size = sizeof(address);
      ::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size);
      if (Peer::of(address).port == coordinator_->bound_port()) sockets.push_back(descriptor);
    }
    return sockets;
  }
};

TEST_F(ListenerTest, OpensASocketAnewThatFails) {
  start(options("127.0.0.1:0"));
  const int port = coordinator_->bound_port();
  EXPECT_TRUE(list_jobs("127.0.0.1").ok());
  ASSERT_EQ(listening_sockets().size(), 1u);
  ASSERT_EQ(::shutdown(listening_sockets().front(), SHUT_RDWR), 0);
  const grpc::Status status = list_jobs("127.0.0.1");
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(coordinator_->bound_port(), port);
}

TEST_F(ListenerTest, AllAddressesAreThoseOfIpv6Too) {
  CoordinatorOptions everywhere = options("0.0.0.0:0");
  everywhere.allow_insecure = true;
  start(everywhere);
  EXPECT_TRUE(list_jobs("127.0.0.1").ok());
  EXPECT_TRUE(list_jobs("[::1]").ok());
}

TEST_F(ListenerTest, ASecondCoordinatorOnThePortIsRefused) {
  start(options("127.0.0.1:0"));
  const auto second = Coordinator::start(options("127.0.0.1:" + std::to_string(coordinator_->bound_port())));
  EXPECT_EQ(second.status().code(), absl::StatusCode::kUnavailable) << second.status();
}

TEST_F(ListenerTest, ConnectionsAreCountedUntilTheyEnd) {
  CoordinatorOptions few = options("127.0.0.1:0");
  few.connections = ConnectionLimits{.all = 4, .of_address = 4, .silent = 4, .silent_of_address = 4};
  start(few);
  // Twelve, one after another, where four may be at once.
  for (int i = 0; i < 12; ++i) {
    const grpc::Status status = list_jobs("127.0.0.1");
    EXPECT_TRUE(status.ok()) << i << ": " << status.error_message();
  }
}

}  // namespace
}  // namespace tessera::server
