// Connections that strangers open without end, beside those of thousands of workers: the coordinator goes on
// serving.
#include <grpcpp/create_channel.h>
#include <grpcpp/generic/generic_stub.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <future>
#include <list>
#include <thread>

#include "base/address.h"
#include "net/channel.h"
#include "soak/load/farm_under_load.h"
#include "soak/load/wait_for.h"
#include "support/long_form.h"
#include "support/process/idle_connections.h"
#include "support/process/tcp_proxy.h"

namespace tessera::load {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::long_form;

constexpr seconds kKeepalive{15};  // then the coordinator closes a connection on which nobody answers
constexpr std::size_t kAtOnce = 1000;
constexpr rlim_t kByHand = 1024;  // descriptors of a program that is started from a shell

/// Gives processes that are started meanwhile this soft limit.
class SoftLimit {
 public:
  explicit SoftLimit(rlim_t descriptors) {
    ::getrlimit(RLIMIT_NOFILE, &before_);
    const rlimit limit{std::min(descriptors, before_.rlim_max), before_.rlim_max};
    ::setrlimit(RLIMIT_NOFILE, &limit);
  }
  ~SoftLimit() {
    const rlimit most{before_.rlim_max, before_.rlim_max};
    ::setrlimit(RLIMIT_NOFILE, &most);
  }
  rlim_t most() const { return before_.rlim_max; }

 private:
  rlimit before_{};
};

/// Somebody who was never there before.
absl::Status call_anew(const std::string& address) {
  auto channel = net::make_channel(address);
  if (!channel.ok()) return channel.status();
  return client::FarmClient{*std::move(channel), {.address = address}}.jobs({}).status();
}

TEST(Strangers, LeaveThousandsOfWorkersAndNewcomersBeServed) {
  const std::size_t workers = long_form() ? 3000 : 300, strangers = long_form() ? 70'000 : 7'000;
  std::optional<FarmUnderLoad> farm;
  {
    const SoftLimit by_hand{kByHand};
    if (by_hand.most() < workers + 2 * kAtOnce)
      GTEST_SKIP() << "the limit of descriptors is " << by_hand.most();
    farm.emplace(TESSERA_SERVER_PROGRAM, std::vector<std::string>{"--log-level", "error"});
  }
  Progress progress;
  const auto jobs = farm->submit({.jobs = 4, .users = 2, .scenes = 2, .units = 100'000}, progress);
  ASSERT_TRUE(jobs.ok()) << jobs.status();
  StubFleet fleet{farm->address(),
                  {.workers = workers,
                   .workers_per_connection = 1,
                   .threads_per_worker = 1,
                   .unit_time = seconds{long_form() ? 20 : 2}},
                  [&](const std::string& job, std::uint32_t unit) { progress.completed(job, unit); }};
  fleet.start();
  ASSERT_TRUE(wait_for([&] { return fleet.registered() >= workers; })) << fleet.registered();

  support::IdleConnections idle{farm->address()};
  for (std::size_t opened = 0; opened < strangers; opened += kAtOnce) {
    idle.open(kAtOnce);
    const std::uint64_t done = progress.done();
    const absl::Status newcomer = call_anew(farm->address());
    ASSERT_TRUE(newcomer.ok()) << newcomer << " after " << opened;
    ASSERT_TRUE(wait_for([&] { return progress.done() > done; })) << "after " << opened;
    idle.close_all();
  }
  const ProcessUse use = farm->use();
  std::printf("%zu workers, %zu strangers: %llu units done, %llu calls tried again, %.0f MiB at most\n",
              workers, strangers, static_cast<unsigned long long>(progress.done()),
              static_cast<unsigned long long>(fleet.tally().retries),
              static_cast<double>(use.peak_resident_bytes) / (1 << 20));
}

/// Calls of which the coordinator gets a part of the request, and never the rest.
class HalfCalls {
 public:
  /// On one connection. They share the memory of `request`.
  HalfCalls(const std::string& address, std::size_t calls, const grpc::ByteBuffer& request) : calls_(calls) {
    grpc::ChannelArguments arguments = net::channel_arguments();
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    grpc::GenericStub stub{grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments)};
    for (Call& call : calls_) {
      call.request = request;
      stub.UnaryCall(&call.context, "/tessera.v1.WorkService/Complete", grpc::StubOptions{}, &call.request,
                     &call.response, [&call](const grpc::Status& status) { call.end.set_value(status); });
    }
  }
  ~HalfCalls() {
    for (Call& call : calls_) call.context.TryCancel();
    for (Call& call : calls_) call.ended.wait();
  }

  bool all_cancelled() const {
    return std::ranges::all_of(calls_, [](const Call& call) {
      return call.ended.wait_for(seconds(0)) == std::future_status::ready;
    });
  }

 private:
  struct Call {
    grpc::ClientContext context;
    grpc::ByteBuffer request, response;
    std::promise<grpc::Status> end;
    std::future<grpc::Status> ended = end.get_future();
  };
  std::vector<Call> calls_;
};

TEST(Strangers, LargeRequestsThatNeverArriveWholeTakeBoundedMemory) {
  constexpr std::size_t kConnections = 8, kCalls = 16;
  constexpr std::size_t kRequestBytes = std::size_t{64} << 20;  // less than wire::kMaxMessageBytes
  constexpr std::size_t kSent = kConnections * kCalls * kRequestBytes / 2;
  // gRPC cancels calls beyond its quota of 280 MiB, one after the other, while more arrives at what loopback
  // carries: 2.0 GiB at most were seen, of 4 without a quota. Then a quarter remains, for the quota and all
  // else.
  constexpr std::size_t kMostAtPeak = kSent / 4 * 3, kMostInTheEnd = kSent / 4;
  // With 1,024 descriptors: the quota grows with the connections that there may be.
  FarmUnderLoad farm{TESSERA_SERVER_PROGRAM,
                     {"--log-level", "error"},
                     {},
                     {"/bin/bash", "-c", "ulimit -n " + std::to_string(kByHand) + "; exec \"$@\"", "bash"}};
  support::TcpProxy proxy{base::parse_host_port(farm.address())->port};
  proxy.forward_at_most(kSent / kConnections);
  const grpc::Slice bytes{std::string(kRequestBytes, 'x')};
  std::list<HalfCalls> halves;
  for (std::size_t i = 0; i < kConnections; ++i)
    halves.emplace_back(proxy.address(), kCalls, grpc::ByteBuffer{&bytes, 1});

  const auto over = [&] {
    return proxy.forwarded() >= kSent || std::ranges::any_of(halves, &HalfCalls::all_cancelled);
  };
  ASSERT_TRUE(wait_for(over)) << proxy.forwarded() << " bytes forwarded";
  EXPECT_LT(farm.use().peak_resident_bytes, kMostAtPeak);
  const auto end = std::chrono::steady_clock::now() + kKeepalive / 2;
  while (farm.use().resident_bytes > kMostInTheEnd && std::chrono::steady_clock::now() < end) {
    const absl::Status newcomer = call_anew(farm.address());
    EXPECT_TRUE(newcomer.ok()) << newcomer;
  }
  const ProcessUse use = farm.use();
  EXPECT_LT(use.resident_bytes, kMostInTheEnd);
  std::printf("%zu MiB of requests: %zu MiB at most, then %zu\n", kSent >> 20,
              static_cast<std::size_t>(use.peak_resident_bytes >> 20),
              static_cast<std::size_t>(use.resident_bytes >> 20));
}

}  // namespace
}  // namespace tessera::load
