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
  units.finish(0, 10);  // by a late result: never taken
  units.take(2);        // taken up out of turn
  EXPECT_EQ(units.take_pending(kAny), 1u);
  units.put_back(1);
  units.finish(1, 11);  // while it waits to be given out again
  EXPECT_EQ(units.take_pending(kAny), 3u);
  EXPECT_EQ(units.take_pending(kAny), std::nullopt);
  EXPECT_EQ(units.done(), 2u);
  EXPECT_EQ(units.result(1), 11u);
  units.put_back(2);  // never taken in turn before
  EXPECT_EQ(units.take_pending(kAny), 2u);
}

}  // namespace
}  // namespace tessera::server
