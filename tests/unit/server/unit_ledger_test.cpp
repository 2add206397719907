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
  units.finish({.fingerprint = 10, .sequence = 1, .units = {.first = 0}});  // by a late result: never taken
  units.take(2);                                                            // taken up out of turn
  EXPECT_EQ(units.take_pending(kAny), 1u);
  units.put_back(1);
  units.finish(
      {.fingerprint = 11, .sequence = 2, .units = {.first = 1}});  // while it waits to be given out again
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
  units.finish({.fingerprint = 7, .sequence = 1, .host = 4, .units = {.first = 2}});
  EXPECT_TRUE(units.settled());
  EXPECT_EQ(units.take_pending(kAny), std::nullopt);
  units.put_back(0);
  EXPECT_FALSE(units.settled());
  EXPECT_EQ(units.set_aside(), 1u);
  ASSERT_EQ(units.results().size(), 1u);
  EXPECT_EQ(units.results()[0].host, 4u);
  units.put_back(2);  // its result was revoked
  EXPECT_EQ(units.done(), 0u);
  EXPECT_EQ(units.take_pending(kAny), 0u);
  EXPECT_EQ(units.take_pending(kAny), 2u);
  units.finish(
      {.fingerprint = 8, .sequence = 2, .units = {.first = 1}});  // a late result of a unit set aside
  EXPECT_EQ(units.set_aside(), 0u);
}

TEST(UnitLedger, OneResultMayCoverARun) {
  UnitLedger units(12);  // three tiles of four ranges
  const UnitRun run{.first = 1, .count = 4, .step = 3};
  units.finish({.fingerprint = 7, .sequence = 2, .host = 1, .units = run});  // the first one was revoked
  EXPECT_EQ(units.done(), 4u);
  for (const std::uint32_t unit : {1, 4, 7, 10}) EXPECT_EQ(units.result(unit).units, run) << unit;
  EXPECT_EQ(units.take_pending(kAny), 0u);
  EXPECT_EQ(units.take_pending(kAny), 2u);
  EXPECT_EQ(units.take_pending(kAny), 3u);
  for (const std::uint32_t unit : run) units.put_back(unit);
  EXPECT_TRUE(units.results().empty()) << "it does not count any more";
  units.finish({.fingerprint = 8, .sequence = 3, .host = 1, .units = {.first = 1}});
  EXPECT_EQ(units.results().size(), 1u);
  EXPECT_EQ(units.take_pending(kAny), 4u);
}

}  // namespace
}  // namespace tessera::server
