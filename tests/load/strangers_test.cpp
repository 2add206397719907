// Connections that strangers open without end, beside those of thousands of workers: the coordinator goes on serving.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <thread>

#include "load/farm_under_load.h"
#include "support/idle_connections.h"
#include "support/long_form.h"
#include "wire/channel.h"

namespace tessera::load {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::long_form;

constexpr seconds kPatience{100};  // reached only when something hangs
constexpr std::size_t kAtOnce = 1000;
constexpr rlim_t kByHand = 1024;  // descriptors of a program that is started from a shell

template <typename Condition>
bool wait_for(Condition condition) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (!condition() && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(milliseconds(10));
  return condition();
}

/// What is started meanwhile has this soft limit.
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
  auto channel = wire::make_channel(address);
  if (!channel.ok()) return channel.status();
  return client::FarmClient{*std::move(channel), {.address = address}}.jobs({}).status();
}

TEST(Strangers, LeaveThousandsOfWorkersAndNewcomersBeServed) {
  const std::size_t workers = long_form() ? 3000 : 300, strangers = long_form() ? 70'000 : 7'000;
  std::optional<FarmUnderLoad> farm;
  {
    const SoftLimit by_hand{kByHand};
    if (by_hand.most() < workers + 2 * kAtOnce) GTEST_SKIP() << "the limit of descriptors is " << by_hand.most();
    farm.emplace(TESSERA_SERVER_PROGRAM, std::vector<std::string>{"--log-level", "error"});
  }
  Progress progress;
  const auto jobs = farm->submit({.jobs = 4, .users = 2, .scenes = 2, .units = 100'000}, progress);
  ASSERT_TRUE(jobs.ok()) << jobs.status();
  StubFleet fleet{
      farm->address(),
      {.workers = workers, .workers_per_connection = 1, .threads = 1, .unit_time = seconds{long_form() ? 20 : 2}},
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
  std::printf("%zu workers, %zu strangers: %llu units done, %llu calls tried again, %.0f MiB at most\n", workers,
              strangers, static_cast<unsigned long long>(progress.done()),
              static_cast<unsigned long long>(fleet.tally().retries),
              static_cast<double>(use.peak_resident_bytes) / (1 << 20));
}

}  // namespace
}  // namespace tessera::load
