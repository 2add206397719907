#include "agent/lease_table.h"

#include <gtest/gtest.h>

#include <array>

namespace tessera::agent {
namespace {

v1::Lease lease(std::uint32_t unit, std::uint32_t attempt = 0, std::uint64_t epoch = 1) {
  v1::Lease lease;
  lease.mutable_token()->set_job_id("job");
  lease.mutable_token()->set_unit_index(unit);
  lease.mutable_token()->set_attempt(attempt);
  lease.mutable_token()->set_epoch(epoch);
  lease.mutable_unit()->set_index(unit);
  return lease;
}

class LeaseTableTest : public ::testing::Test {
 protected:
  void add(const v1::Lease& granted) { table_.add(granted, std::make_shared<v1::JobSpec>()); }

  LeaseTable table_{base::machine_clock()};
};

TEST_F(LeaseTableTest, GivesUnitsInTheOrderOfTheirGrant) {
  add(lease(5));
  add(lease(2));
  EXPECT_EQ(table_.next({})->unit.index(), 5U);
  EXPECT_EQ(table_.next({})->unit.index(), 2U);
  EXPECT_EQ(table_.tokens().size(), 2U) << "a unit is held until it is released";
}

TEST_F(LeaseTableTest, NextEndsWhenStopped) {
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(table_.next(stop.get_token()), nullptr);
}

TEST_F(LeaseTableTest, AHeldUnitTakesOverANewerTokenAndIsNotRenderedTwice) {
  add(lease(1, 0, 1));
  const auto held = table_.next({});
  add(lease(1, 3, 2));
  EXPECT_EQ(table_.token(*held).attempt(), 3U);
  EXPECT_EQ(table_.token(*held).epoch(), 2U);
  table_.wait_until_hungry({});
  EXPECT_EQ(table_.tokens().size(), 1U);
}

TEST_F(LeaseTableTest, RevokesOnlyTheTokenThatIsNamed) {
  add(lease(1, 0));
  const auto held = table_.next({});
  EXPECT_EQ(table_.revoke(std::array{lease(1, 7).token()}), 0U) << "another attempt's token";
  EXPECT_FALSE(held->stop.stop_requested());
  EXPECT_EQ(table_.revoke(std::array{lease(1, 0).token()}), 1U);
  EXPECT_TRUE(held->stop.stop_requested());
}

TEST_F(LeaseTableTest, ARevokedUnitThatWasNotBegunIsForgotten) {
  add(lease(1));
  table_.revoke(std::array{lease(1).token()});
  EXPECT_TRUE(table_.tokens().empty());
  table_.wait_until_hungry({});
}

TEST_F(LeaseTableTest, AUnitGrantedAnewAfterItsRevocationIsAFreshStart) {
  add(lease(1, 0));
  const auto revoked = table_.next({});
  table_.revoke(std::array{lease(1, 0).token()});
  add(lease(1, 1));
  const auto anew = table_.next({});
  EXPECT_NE(anew, revoked);
  EXPECT_FALSE(anew->stop.stop_requested());
  table_.release(*revoked);
  EXPECT_EQ(table_.tokens().size(), 1U) << "the old grant's release must not take the new one with it";
  table_.release(*anew);
  EXPECT_TRUE(table_.wait_until_empty(std::chrono::milliseconds{0}));
}

TEST_F(LeaseTableTest, AUnitGrantedAnewAfterItFailedIsAFreshStart) {
  add(lease(1, 0));
  const auto failed = table_.next({});
  table_.give_up(*failed);
  EXPECT_EQ(table_.token(*failed).attempt(), 0U);
  add(lease(1, 5));
  const auto anew = table_.next({});
  EXPECT_NE(anew, failed);
  EXPECT_EQ(table_.token(*anew).attempt(), 5U);
  EXPECT_EQ(table_.token(*failed).attempt(), 0U) << "a failure must not be told of the new grant";
  table_.release(*failed);
  EXPECT_EQ(table_.tokens().size(), 1U);
}

TEST_F(LeaseTableTest, WhatIsAskedForIsNotAskedForAgain) {
  EXPECT_EQ(table_.ask(4), 4U);
  EXPECT_EQ(table_.ask(4), 0U);
  for (const std::uint32_t unit : {1, 2, 3}) add(lease(unit));
  table_.answered(4);
  EXPECT_EQ(table_.ask(4), 0U) << "more than half is there";
  static_cast<void>(table_.next({}));
  EXPECT_EQ(table_.ask(4), 2U);
  table_.answered(2);
  EXPECT_EQ(table_.ask(1), 0U) << "two are queued";
}

/// After a restart: the coordinator grants what is pending, and then hears that this worker has rendered it.
TEST_F(LeaseTableTest, AGrantFromBeforeTheUnitWasDeliveredIsLeftOut) {
  add(lease(1));
  const auto held = table_.next({});
  const std::uint64_t asked_at = table_.deliveries();
  table_.delivered(*held);
  table_.release(*held);
  table_.add(lease(1), std::make_shared<v1::JobSpec>(), asked_at);
  EXPECT_TRUE(table_.tokens().empty());
  // One that was asked for since is meant: the result was lost, or proved wrong.
  table_.add(lease(1), std::make_shared<v1::JobSpec>(), table_.deliveries());
  EXPECT_EQ(table_.tokens().size(), 1U);
}

TEST_F(LeaseTableTest, DropQueuedKeepsWhatWasBegun) {
  add(lease(1));
  add(lease(2));
  const auto begun = table_.next({});
  EXPECT_EQ(table_.drop_queued(), 1U);
  ASSERT_EQ(table_.tokens().size(), 1U);
  EXPECT_EQ(table_.tokens()[0].unit_index(), 1U);
  EXPECT_FALSE(begun->stop.stop_requested());
  add(lease(3));
  EXPECT_EQ(table_.tokens().size(), 1U) << "what comes late goes back";
  EXPECT_EQ(table_.ask(8), 0U);
}

}  // namespace
}  // namespace tessera::agent
