#include "service/farm/dispatcher.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <string>
#include <thread>
#include <vector>

namespace tessera::server {
namespace {

using namespace std::chrono_literals;

TEST(Dispatcher, WhatIsParkedIsTriedWhenThereIsWork) {
  Dispatcher dispatcher(base::machine_clock(), [] {});
  std::atomic<bool> work = false;
  std::promise<bool> answered;
  dispatcher.park("worker", base::machine_clock().now() + 1h, [&](bool last) {
    if (!work) return false;
    answered.set_value(last);
    return true;
  });
  work = true;
  dispatcher.notify_work();
  EXPECT_FALSE(answered.get_future().get());
}

TEST(Dispatcher, TheLastTryComesAtTheDeadline) {
  Dispatcher dispatcher(base::machine_clock(), [] {});
  std::promise<void> answered;
  dispatcher.park("worker", base::machine_clock().now(), [&](bool last) {
    if (last) answered.set_value();
    return last;
  });
  answered.get_future().get();
}

TEST(Dispatcher, OfManyThatFindNothingEachHasItsTurn) {
  constexpr std::size_t kMany = 1500;
  // All but these two are of the dispatcher's thread alone.
  std::atomic<std::size_t> parked = 0;
  std::atomic<bool> all_parked = false;
  std::vector<int> tries(kMany);
  std::vector<bool> tried_when_parked(kMany);
  std::size_t tried = 0, in_one_round = 0, most_in_one_round = 0;
  int most = 0;
  std::promise<void> all_tried;
  Dispatcher dispatcher(base::machine_clock(),
                        [&] { in_one_round = 0; });  // nobody notifies, so each tick begins a round
  for (std::size_t i = 0; i < kMany; ++i) {
    dispatcher.park(std::to_string(i), base::machine_clock().now() + 1h, [&, i](bool last) {
      if (!all_parked && !tried_when_parked[i]) {
        tried_when_parked[i] = true;
        ++parked;
      }
      if (!all_parked || last) return last;
      most = std::max(most, ++tries[i]);
      most_in_one_round = std::max(most_in_one_round, ++in_one_round);
      if (tries[i] == 1 && ++tried == kMany) all_tried.set_value();
      return false;
    });
  }
  while (parked < kMany) std::this_thread::yield();
  all_parked = true;
  all_tried.get_future().get();
  dispatcher.stop();
  EXPECT_LE(most, 2);
  EXPECT_LT(most_in_one_round, kMany);
}

TEST(Dispatcher, AWorkerWithAFreeHandDoesNotWaitForItsTurn) {
  constexpr int kMany = 4000;  // eight turns of those who find nothing
  std::atomic<int> ticks = 0;
  std::atomic<bool> has_work = false;
  std::promise<int> answered;
  Dispatcher dispatcher(base::machine_clock(), [&] { ++ticks; });
  for (int i = 0; i < kMany; ++i) {
    dispatcher.park(std::to_string(i), base::machine_clock().now() + 1h, [](bool last) { return last; });
  }
  dispatcher.park("free", base::machine_clock().now() + 1h, [&](bool last) {
    if (has_work && !last) answered.set_value(ticks);
    return has_work || last;
  });
  has_work = true;
  const int before = ticks;
  dispatcher.notify_worker("free");
  EXPECT_LE(answered.get_future().get(), before + 2);
}

TEST(Dispatcher, StoppingAnswersAllAndLaterOnesAtOnce) {
  int last_tries = 0, wakes = 0;
  Dispatcher dispatcher(base::machine_clock(), [] {});
  const auto attempt = [&](bool last) { return last && ++last_tries > 0; };
  dispatcher.park("worker", base::machine_clock().now() + 1h, attempt);
  dispatcher.stop();
  EXPECT_EQ(last_tries, 1);
  dispatcher.park("worker", base::machine_clock().now() + 1h, attempt);
  EXPECT_EQ(last_tries, 2);
  dispatcher.subscribe([&] { return ++wakes < 0; });
  EXPECT_EQ(wakes, 1);
}

TEST(Dispatcher, SubscribersAreWokenUntilTheyHaveEnough) {
  Dispatcher dispatcher(base::machine_clock(), [] {});
  std::promise<void> woken_thrice;
  int wakes = 0;
  dispatcher.subscribe([&] {
    dispatcher.notify_news();
    if (++wakes < 3) return true;
    woken_thrice.set_value();
    return false;
  });
  dispatcher.notify_news();
  woken_thrice.get_future().get();
  dispatcher.stop();
  EXPECT_EQ(wakes, 3);
}

}  // namespace
}  // namespace tessera::server
