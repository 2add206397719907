#include "service/farm/lived_time.h"

#include <gtest/gtest.h>

#include <fstream>

#include "support/process/temp_dir.h"

namespace tessera::server {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
using Time = LivedTime::Time;

constexpr Time kSteadyStart = hours{1000};
constexpr Time kWall = hours{500'000};

class LivedTimeTest : public testing::Test {
 protected:
  void save(const LivedTime& time) { ASSERT_TRUE(LivedTime::save(time.file(), time.to_text()).ok()); }

  support::TempDir folder_;
  const std::filesystem::path file_ = folder_.path() / "lived-time";
};

TEST_F(LivedTimeTest, StepsOfTheWallsClockMakeNothingOlder) {
  LivedTime time;
  EXPECT_EQ(time.advance(kSteadyStart, kWall), Time{0});
  EXPECT_EQ(time.since_end_of("a"), Time{0});
  EXPECT_EQ(time.advance(kSteadyStart + hours{1}, kWall + hours{1}), Time{0});
  EXPECT_EQ(time.since_end_of("a"), hours{1});
  EXPECT_EQ(time.advance(kSteadyStart + hours{2}, kWall + hours{2 + 400 * 24}), hours{400 * 24});
  EXPECT_EQ(time.since_end_of("a"), hours{2});
  EXPECT_EQ(time.advance(kSteadyStart + hours{3}, kWall), -hours{3 + 400 * 24});
  EXPECT_EQ(time.since_end_of("a"), hours{3});
}

TEST_F(LivedTimeTest, GoesOnAfterARestartAndTimeBetweenDoesNotCount) {
  {
    LivedTime first{file_};
    first.advance(kSteadyStart, kWall);
    first.since_end_of("a");
    first.advance(kSteadyStart + hours{5}, kWall + hours{5});
    first.since_end_of("b");
    save(first);
  }
  LivedTime second{file_};
  EXPECT_EQ(second.advance(Time{7}, kWall + hours{1000}), Time{0}) << "nobody knows how long it was";
  EXPECT_EQ(second.since_end_of("a"), hours{5});
  EXPECT_EQ(second.since_end_of("b"), Time{0});
  second.advance(Time{7} + hours{1}, kWall + hours{1001});
  EXPECT_EQ(second.since_end_of("a"), hours{6});
}

TEST_F(LivedTimeTest, AJobThatGoesOnEndsAnew) {
  LivedTime time;
  time.advance(kSteadyStart, kWall);
  time.since_end_of("a");
  time.advance(kSteadyStart + hours{1}, kWall + hours{1});
  time.forget("a");
  EXPECT_EQ(time.since_end_of("a"), Time{0});
}

TEST_F(LivedTimeTest, ADamagedFileKeepsJobsForLonger) {
  for (const char* text : {"", "something else\n1\n", "tessera lived-time 1\n", "tessera lived-time 1\n-5\n",
                           "tessera lived-time 1\n10\na 11\n", "tessera lived-time 1\n10\na x\n",
                           "tessera lived-time 1\n10\na 5\nb\n"}) {
    std::ofstream{file_} << text;
    LivedTime time{file_};
    EXPECT_EQ(time.since_end_of("a"), Time{0}) << text;
  }
}

}  // namespace
}  // namespace tessera::server
