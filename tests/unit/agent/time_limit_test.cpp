#include "agent/time_limit.h"

#include <gtest/gtest.h>

#include <latch>

namespace tessera::agent {
namespace {

using std::chrono::milliseconds;

TEST(TimeLimit, StopsWhatTakesTooLong) {
  TimeLimit limit{milliseconds{20}};
  std::stop_source long_work;
  TimeLimit::Watch watch(limit, long_work);
  std::latch stopped{1};
  const std::stop_callback on_stop{long_work.get_token(), [&] { stopped.count_down(); }};
  stopped.wait();
  EXPECT_TRUE(watch.expired());
}

TEST(TimeLimit, LeavesAloneWhatEndsInTime) {
  std::stop_source done, later;
  TimeLimit limit{milliseconds{20}};
  { const TimeLimit::Watch watch(limit, done); }
  // Once the second watch has expired, the first would have.
  const TimeLimit::Watch watch(limit, later);
  std::latch stopped{1};
  const std::stop_callback on_stop{later.get_token(), [&] { stopped.count_down(); }};
  stopped.wait();
  EXPECT_FALSE(done.stop_requested());
}

TEST(TimeLimit, ZeroIsNone) {
  TimeLimit limit{milliseconds{0}};
  std::stop_source work;
  const TimeLimit::Watch watch(limit, work);
  EXPECT_FALSE(watch.expired());
}

}  // namespace
}  // namespace tessera::agent
