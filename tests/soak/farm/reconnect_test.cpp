// How soon programs find a coordinator that starts after them, or again.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <string>
#include <thread>

#include "integration/farm_under_test.h"

namespace tessera::integration {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;
using std::chrono::seconds;

// Between two tries of a connection lies a second at most; the rest is the program's own.
constexpr double kSoon = 2;       // seconds
constexpr seconds kHeadStart{2};  // a program starts this long before its coordinator
constexpr seconds kOutage{8};     // long enough for every back-off to have reached its end

double since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

/// How many seconds after `begin` the program's stderr held `text` behind its first `from` bytes.
double seconds_until_said(const support::Process& process, std::size_t from, const std::string& text,
                          Clock::time_point begin) {
  while (process.err(from).find(text) == std::string::npos) {
    if (since(begin) > 30) break;
    std::this_thread::sleep_for(milliseconds{5});
  }
  const double waited = since(begin);
  std::printf("%.2f s until \"%s\"\n", waited, text.c_str());
  return waited;
}

TEST(Reconnect, AClientThatStartsBeforeItsCoordinator) {
  FarmUnderTest farm;
  farm.kill_coordinator();
  support::Process jobs{Arguments{tessera_program()} + farm.on_farm({"jobs"})};
  std::this_thread::sleep_for(kHeadStart);
  farm.restart_coordinator();
  const auto listening = Clock::now();
  const std::optional<support::ExitStatus> end = jobs.wait(kPatience);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, 0) << jobs.err();
  EXPECT_LT(since(listening), kSoon);
}

TEST(Reconnect, AWorkerThatStartsBeforeItsCoordinator) {
  FarmUnderTest farm;
  farm.kill_coordinator();
  support::Process& worker = farm.add_worker(1);
  std::this_thread::sleep_for(kHeadStart);
  farm.restart_coordinator();
  EXPECT_LT(seconds_until_said(worker, 0, "registered with", Clock::now()), kSoon) << worker.err();
}

TEST(Reconnect, WhoeverHasWaitedForLongGoesOnAtOnce) {
  FarmUnderTest farm;
  support::Process& worker = farm.add_worker(1);
  const Arguments job = in_many_units("256", "4096");
  const std::string id = farm.submit_detached(job);
  farm.watch_until(id, [](const v1::JobStatus& status) { return status.units_done() > 0; });
  support::Process watch{Arguments{tessera_program()} + farm.on_farm({"watch", id})};
  ASSERT_TRUE(watch.wait_for_err("%", kPatience)) << watch.err();
  farm.kill_coordinator();
  std::this_thread::sleep_for(kOutage);
  const std::size_t of_worker = worker.err().size(), of_watch = watch.err().size();
  farm.restart_coordinator();
  const auto listening = Clock::now();
  EXPECT_LT(seconds_until_said(worker, of_worker, " leased", listening), kSoon) << worker.err(of_worker);
  EXPECT_LT(seconds_until_said(watch, of_watch, "answers again", listening), kSoon + 1)
      << watch.err(of_watch);
}

}  // namespace
}  // namespace tessera::integration
