#include "agent/time_limit.h"

#include <gtest/gtest.h>

#include <latch>

namespace tessera::agent {
namespace {

using std::chrono::milliseconds;

TEST(TimeLimit, StopsWhatTakesTooLong) {
  TimeLimit limit{base::machine_clock(), milliseconds{20}};
  const std::stop_source revoked;
  const TimeLimit::Watch watch(limit, revoked.get_token());
  std::latch stopped{1};
  const std::stop_callback on_stop{watch.token(), [&] { stopped.count_down(); }};
  stopped.wait();
  EXPECT_TRUE(watch.expired());
  EXPECT_FALSE(revoked.stop_requested()) << "a unit that took too long was not called back";
}

TEST(TimeLimit, PassesOnARequestToStop) {
  TimeLimit limit{base::machine_clock(), std::chrono::hours{1}};
  std::stop_source revoked;
  const TimeLimit::Watch watch(limit, revoked.get_token());
  EXPECT_FALSE(watch.token().stop_requested());
  revoked.request_stop();
  EXPECT_TRUE(watch.token().stop_requested());
  EXPECT_FALSE(watch.expired());
}

TEST(TimeLimit, LeavesAloneWhatEndsInTime) {
  TimeLimit limit{base::machine_clock(), milliseconds{20}};
  std::stop_token done;
  {
    const TimeLimit::Watch watch(limit, {});
    done = watch.token();
  }
  // Once the second watch has expired, the first would have.
  const TimeLimit::Watch watch(limit, {});
  std::latch stopped{1};
  const std::stop_callback on_stop{watch.token(), [&] { stopped.count_down(); }};
  stopped.wait();
  EXPECT_FALSE(done.stop_requested());
}

TEST(TimeLimit, ZeroIsNone) {
  TimeLimit limit{base::machine_clock(), milliseconds{0}};
  const TimeLimit::Watch watch(limit, {});
  EXPECT_FALSE(watch.expired());
}

}  // namespace
}  // namespace tessera::agent
