#include "scheduler/unit_ledger.h"

#include <gtest/gtest.h>

namespace tessera::server {
namespace {

constexpr auto kAny = [](std::uint32_t) { return true; };

TEST(UnitLedger, GivesTheLowestPendingUnitFirst) {
  UnitLedger units(5);
  EXPECT_EQ(units.take_pending(kAny), 0u);
  EXPECT_EQ(units.take_pending(kAny), 1u);
  EXPECT_EQ(units.take_pending(kAny), 2u);
  units.put_back(1);
  units.put_back(0);
  EXPECT_EQ(units.pending(), 4u);
  EXPECT_EQ(units.take_pending(kAny), 0u);
  EXPECT_EQ(units.take_pending(kAny), 1u);
  EXPECT_EQ(units.take_pending(kAny), 3u);
}

TEST(UnitLedger, WhatDoesNotSuitStaysPending) {
  UnitLedger units(3);
  EXPECT_EQ(units.take_pending([](std::uint32_t unit) { return unit == 2; }), 2u);
  EXPECT_EQ(units.take_pending([](std::uint32_t unit) { return unit == 2; }), std::nullopt);
  EXPECT_EQ(units.pending(), 2u);
  EXPECT_EQ(units.take_pending(kAny), 0u);
}

TEST(UnitLedger, UnitsDoneOutOfTurnDoNotComeUp) {
  UnitLedger units(4);
  units.finish(0, {.fingerprint = 10, .sequence = 1, .host = 0});  // by a late result: never taken
  units.take(2);                                                   // taken up out of turn
  EXPECT_EQ(units.take_pending(kAny), 1u);
  units.put_back(1);
  units.finish(1, {.fingerprint = 11, .sequence = 1, .host = 0});  // while it waits to be given out again
  EXPECT_EQ(units.take_pending(kAny), 3u);
  EXPECT_EQ(units.take_pending(kAny), std::nullopt);
  EXPECT_EQ(units.done(), 2u);
  EXPECT_EQ(units.result(1).fingerprint, 11u);
  units.put_back(2);  // never taken in turn before
  EXPECT_EQ(units.take_pending(kAny), 2u);
}

TEST(UnitLedger, CountsFollowEveryChangeOfState) {
  UnitLedger units(3);
  units.take(0);
  units.set_aside(0);
  units.set_aside(1);
  EXPECT_EQ(units.pending(), 1u);
  units.finish(2, {.fingerprint = 7, .sequence = 1, .host = 4});
  EXPECT_TRUE(units.settled());
  EXPECT_EQ(units.take_pending(kAny), std::nullopt);
  units.put_back(0);
  EXPECT_FALSE(units.settled());
  EXPECT_EQ(units.set_aside(), 1u);
  EXPECT_EQ(units.done_by(4), std::vector<std::uint32_t>{2});
  units.put_back(2);  // its result was revoked
  EXPECT_EQ(units.done(), 0u);
  EXPECT_EQ(units.take_pending(kAny), 0u);
  EXPECT_EQ(units.take_pending(kAny), 2u);
  units.finish(1, {.fingerprint = 8, .sequence = 2, .host = 0});  // a late result of a unit set aside
  EXPECT_EQ(units.set_aside(), 0u);
}

}  // namespace
}  // namespace tessera::server
