#include "scheduler/unit_ledger.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace tessera::server {
namespace {

constexpr auto kAny = [](std::uint32_t) { return true; };

TEST(UnitLedger, GivesTheLowestPendingUnitFirst) {
  UnitLedger units(5);
  units.open_until(units.count());
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
  units.open_until(units.count());
  EXPECT_EQ(units.take_pending([](std::uint32_t unit) { return unit == 2; }), 2u);
  EXPECT_EQ(units.take_pending([](std::uint32_t unit) { return unit == 2; }), std::nullopt);
  EXPECT_EQ(units.pending(), 2u);
  EXPECT_EQ(units.take_pending(kAny), 0u);
}

TEST(UnitLedger, UnitsDoneOutOfTurnDoNotComeUp) {
  UnitLedger units(4);
  units.open_until(units.count());
  units.finish({.fingerprint = 10, .sequence = 1, .units = {.first = 0}});  // a late result: never taken
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

TEST(UnitLedger, KeepsCountOverManyUnits) {
  constexpr std::uint32_t kUnits = 100'000;  // many pages, the last one not full
  UnitLedger units(kUnits);
  units.finish({.fingerprint = 1, .sequence = 1, .units = {.first = 50'000, .count = 2, .step = 10'000}});
  units.open_until(5'000);
  EXPECT_EQ(units.pending(), 5'000u);
  units.open_until(60'000);
  EXPECT_EQ(units.pending(), 59'999u);
  units.open_until(kUnits);
  EXPECT_EQ(units.pending(), kUnits - 2);
  std::vector<std::uint32_t> taken;
  while (const auto unit = units.take_pending(kAny)) taken.push_back(*unit);
  EXPECT_EQ(taken.size(), kUnits - 2);
  EXPECT_TRUE(std::ranges::is_sorted(taken));
  EXPECT_EQ(units.leased(), kUnits - 2);
  for (const std::uint32_t unit : taken) units.put_back(unit);
  units.close_from(50'001);
  EXPECT_EQ(units.pending(), 50'000u);
  units.open_until(kUnits);
  EXPECT_EQ(units.pending(), kUnits - 2);
  EXPECT_EQ(units.result(60'000).fingerprint, 1u);
}

TEST(UnitLedger, CountsFollowEveryChangeOfState) {
  UnitLedger units(3);
  units.open_until(units.count());
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
  units.open_until(units.count());
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

TEST(UnitLedger, OnlyOpenUnitsAreGivenOut) {
  UnitLedger units(6);
  EXPECT_EQ(units.pending(), 0u);
  EXPECT_EQ(units.take_pending(kAny), std::nullopt);
  units.open_until(2);
  EXPECT_EQ(units.pending(), 2u);
  EXPECT_EQ(units.take_pending(kAny), 0u);
  EXPECT_EQ(units.take_pending(kAny), 1u);
  EXPECT_EQ(units.take_pending(kAny), std::nullopt);
  EXPECT_FALSE(units.settled()) << "two are out";
  units.finish({.fingerprint = 1, .sequence = 1, .units = {.first = 0}});
  units.finish({.fingerprint = 2, .sequence = 2, .units = {.first = 1}});
  EXPECT_TRUE(units.settled());
  units.open_until(6);
  EXPECT_EQ(units.take_pending(kAny), 2u);
  units.finish({.fingerprint = 3, .sequence = 3, .units = {.first = 2}});

  // Closed again, while one of them is done and another one waits to be given out again.
  EXPECT_EQ(units.take_pending(kAny), 3u);
  units.put_back(3);
  units.put_back(1);
  units.close_from(2);
  EXPECT_EQ(units.pending(), 1u);
  EXPECT_EQ(units.take_pending(kAny), 1u);
  EXPECT_EQ(units.take_pending(kAny), std::nullopt);
  units.finish({.fingerprint = 4, .sequence = 4, .units = {.first = 1}});
  units.open_until(6);
  EXPECT_EQ(units.pending(), 3u) << "the third is done still";
  for (const std::uint32_t unit : {3u, 4u, 5u}) EXPECT_EQ(units.take_pending(kAny), unit);
  EXPECT_EQ(units.take_pending(kAny), std::nullopt);
}

}  // namespace
}  // namespace tessera::server
