#include "base/clock.h"

#include <gtest/gtest.h>

#include <mutex>
#include <string>
#include <vector>

#include "support/sequencer.h"

namespace tessera::base {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
using test::Sequencer;

TEST(MachineClock, AWaitEndsWithItsDeadlineAndWithAStop) {
  Clock& clock = machine_clock();
  Condition never(clock);
  std::mutex mutex;
  std::unique_lock lock(mutex);
  EXPECT_FALSE(never.wait_until(lock, {}, clock.now() + milliseconds{1}, [] { return false; }));
  std::stop_source stop;
  const Thread stopper = clock.start("stopper", [&](std::stop_token) { stop.request_stop(); });
  EXPECT_FALSE(never.wait(lock, stop.get_token(), [] { return false; }));
}

TEST(MachineClock, ThreadsWakeEachOther) {
  constexpr int kEnd = 1000;
  Clock& clock = machine_clock();
  std::mutex mutex;
  Condition changed(clock);
  int count = 0;
  const auto count_in_turn = [&](int remainder) {
    return [&, remainder](std::stop_token) {
      std::unique_lock lock(mutex);
      while (count < kEnd) {
        changed.wait(lock, [&] { return count == kEnd || count % 2 == remainder; });
        count += count < kEnd;
        changed.notify_one();
      }
    };
  };
  Thread even = clock.start("even", count_in_turn(0)), odd = clock.start("odd", count_in_turn(1));
  even.join();
  odd.join();
  EXPECT_EQ(count, kEnd);
}

/// The course of three threads that sleep, in order.
std::string course(std::uint64_t seed) {
  Sequencer clock(seed, hours{1}, "");
  std::string course;
  std::vector<Thread> threads;
  for (const char name : {'a', 'b', 'c'}) {
    threads.push_back(clock.start(std::string(1, name), [&, name](std::stop_token stop) {
      for (int i = 0; i < 3; ++i) {
        course += name;
        pause(clock, milliseconds{1}, stop);
      }
    }));
  }
  for (Thread& thread : threads) thread.join();
  return course;
}

TEST(Sequencer, TheSeedSaysWhoseTurnItIs) {
  EXPECT_EQ(course(1), course(1));
  EXPECT_NE(course(1), course(2));
}

TEST(Sequencer, TimePassesWhenAllWait) {
  Sequencer clock(1, hours{10}, "");
  const Clock::TimePoint begin = clock.now();
  const Thread early = clock.start("early", [&](std::stop_token stop) {
    pause(clock, hours{1}, stop);
    EXPECT_EQ(clock.now() - begin, hours{1});
  });
  EXPECT_TRUE(pause(clock, hours{2}, {}));
  EXPECT_EQ(clock.now() - begin, hours{2});
}

TEST(Sequencer, AStopEndsAWaitAtOnce) {
  Sequencer clock(1, hours{1}, "");
  bool stopped = false;
  Thread sleeper =
      clock.start("sleeper", [&](std::stop_token stop) { stopped = !pause(clock, hours{9}, stop); });
  pause(clock, milliseconds{1}, {});
  sleeper = Thread();
  EXPECT_TRUE(stopped);
}

TEST(SequencerDeathTest, AHangSaysWhoWaitsWhere) {
  EXPECT_DEATH(
      {
        Sequencer clock(1, hours{1}, "seed 1");
        std::mutex mutex;
        Condition never(clock);
        Thread waiting = clock.start("somebody", [&](std::stop_token) {
          std::unique_lock lock(mutex);
          never.wait(lock, [] { return false; });
        });
        waiting.join();
      },
      "all wait for each other(.|\n)*main #1 waits at somebody(.|\n)*"
      "somebody #2 waits at .*clock_test.cpp:[0-9]+(.|\n)*again: seed 1");
}

TEST(SequencerDeathTest, WhatDoesNotEndIsEnded) {
  EXPECT_DEATH(
      {
        Sequencer clock(1, hours{1}, "seed 1");
        while (true) pause(clock, milliseconds{250}, {});
      },
      "it does not end");
}

}  // namespace
}  // namespace tessera::base
