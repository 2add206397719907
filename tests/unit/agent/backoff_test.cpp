#include "net/backoff.h"

#include <gtest/gtest.h>

namespace tessera::net {
namespace {

using std::chrono::milliseconds;

TEST(Backoff, DrawsFromTheUpperHalfOfADoublingBound) {
  Backoff backoff{milliseconds{100}, milliseconds{400}, /*seed=*/1};
  for (const int bound : {100, 200, 400, 400, 400}) {
    const milliseconds delay = backoff.next();
    EXPECT_GE(delay, milliseconds{bound / 2});
    EXPECT_LE(delay, milliseconds{bound});
  }
  backoff.reset();
  EXPECT_LE(backoff.next(), milliseconds{100});
}

TEST(Backoff, TwoWorkersDoNotComeBackTogether) {
  Backoff one{milliseconds{1000}, milliseconds{100'000}, /*seed=*/1};
  Backoff other{milliseconds{1000}, milliseconds{100'000}, /*seed=*/2};
  int together = 0;
  for (int i = 0; i < 6; ++i) together += one.next() == other.next();
  // Each pair is equal with a probability of 1 in 500 at most.
  EXPECT_EQ(together, 0);
}

TEST(Backoff, AStopEndsTheWait) {
  std::stop_source stop;
  stop.request_stop();
  EXPECT_FALSE(interruptible_sleep(std::chrono::hours{1}, stop.get_token()));
  EXPECT_TRUE(interruptible_sleep(milliseconds{0}, {}));
}

}  // namespace
}  // namespace tessera::net
