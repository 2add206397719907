#include "service/job/completion_rate.h"

#include <gtest/gtest.h>

namespace tessera::server {
namespace {

constexpr Time at(int second) { return Time{second * 1000}; }

TEST(CompletionRate, IsNotKnownBeforeTheSecondResult) {
  CompletionRate rate;
  EXPECT_FALSE(rate.time_for(10, at(0)));
  rate.note(1, at(1));
  EXPECT_FALSE(rate.time_for(10, at(2)));
  rate.note(2, at(2));
  EXPECT_EQ(rate.time_for(10, at(2)), at(10));
}

TEST(CompletionRate, CountsFromTheFirstResultOn) {
  CompletionRate rate;
  rate.note(1000, at(100));  // taken over, or of before a restart
  rate.note(1010, at(110));
  EXPECT_EQ(rate.time_for(50, at(110)), at(50));
}

TEST(CompletionRate, FollowsWhatTheLastTwoMinutesWere) {
  CompletionRate rate;
  for (int s = 0; s <= 600; ++s) rate.note(static_cast<std::uint64_t>(s), at(s));  // one a second
  for (int s = 601; s <= 800; ++s)
    rate.note(600 + 10 * static_cast<std::uint64_t>(s - 600), at(s));  // then ten
  EXPECT_EQ(rate.time_for(1000, at(800)), at(100));
}

TEST(CompletionRate, GrowsLongerWhileNothingComes) {
  CompletionRate rate;
  for (int s = 0; s <= 10; ++s) rate.note(static_cast<std::uint64_t>(s), at(s));
  EXPECT_EQ(rate.time_for(10, at(10)), at(10));
  EXPECT_EQ(rate.time_for(10, at(100)), at(100));
}

}  // namespace
}  // namespace tessera::server
