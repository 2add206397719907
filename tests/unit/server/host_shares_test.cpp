// Who is slow with a job.
#include "service/job/host_shares.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "absl/strings/str_cat.h"
#include "service/job/job_table.h"
#include "support/phased_job.h"
#include "unit/server/requests.h"

namespace tessera::server {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// Twice as many as it takes to be sure of a factor of five between two hosts.
constexpr int kRounds = 200;

using Seconds = std::chrono::duration<double>;

void add(HostShares& shares, const std::string& host, Seconds taken) {
  shares.count(host, 1);
  shares.time(host, std::chrono::duration_cast<std::chrono::nanoseconds>(taken));
}

/// So many rounds, in each of which every host returns a unit that takes it so many seconds.
void add_rounds(HostShares& shares, int rounds, const std::vector<std::pair<std::string, double>>& hosts) {
  for (int i = 0; i < rounds; ++i) {
    for (const auto& [host, unit_seconds] : hosts) add(shares, host, Seconds(unit_seconds));
  }
}

std::vector<std::string> names(const std::vector<HostShare>& shares) {
  std::vector<std::string> hosts;
  for (const HostShare& share : shares) hosts.push_back(share.host);
  return hosts;
}

TEST(HostShares, NameHostsThatTakeTwiceAsLong) {
  HostShares shares;
  add_rounds(shares, 40, {{"a", 10}, {"b", 11}, {"c", 9}, {"d", 10}});
  EXPECT_THAT(shares.slow(), IsEmpty());
  add_rounds(shares, kRounds, {{"a", 10}, {"b", 11}, {"c", 9}, {"d", 10}, {"slow", 40}, {"slower", 200}});
  ASSERT_THAT(names(shares.slow()), ElementsAre("slower", "slow"));
  EXPECT_EQ(shares.slow().front().timed_units, 1u * kRounds);
  // Only the part that is beyond doubt is told, which is less than the true ratio.
  EXPECT_GT(shares.slow().front().slowness, 2 * shares.slow().back().slowness);
  EXPECT_LT(shares.slow().front().slowness, 22);
}

TEST(HostShares, OfTwoTheFasterIsUsual) {
  HostShares shares;
  add_rounds(shares, 4, {{"a", 50}});
  EXPECT_THAT(shares.slow(), IsEmpty());
  add_rounds(shares, kRounds, {{"a", 50}, {"b", 10}});
  EXPECT_THAT(names(shares.slow()), ElementsAre("a"));
}

TEST(HostShares, UnevenCostsMakeNoHostSlow) {
  std::mt19937_64 random(1);
  std::lognormal_distribution<double> cost(
      0, 1.15);  // two decades: the mean of 20 is uncertain by a factor of 1.4
  HostShares shares;
  for (int i = 0; i < 4000; ++i) {
    // Beyond 4.5 standard deviations seven times in a million, and then by far less than kSlow.
    add(shares, absl::StrCat("host ", random() % 40), Seconds(cost(random)));
    ASSERT_THAT(shares.slow(), IsEmpty()) << i;
  }
}

TEST(HostShares, SlownessShowsThroughUnevenCosts) {
  std::mt19937_64 random(2);
  std::lognormal_distribution<double> cost(0, 1.15);
  HostShares shares;
  for (int i = 0; i < 4000; ++i) {
    const std::uint64_t host = random() % 20;
    add(shares, absl::StrCat("host ", host), Seconds(cost(random) * (host == 7 ? 8 : 1)));
  }
  // 200 units each: a standard deviation of 1.3 / sqrt(200) = 0.09, 4.5 of them are less than ln 8 - ln 2.
  ASSERT_THAT(names(shares.slow()), ElementsAre("host 7"));
  EXPECT_NEAR(shares.slow().front().slowness, 8, 3);
}

TEST(HostShares, FewUnitsSayNothing) {
  HostShares shares;
  add_rounds(shares, 3, {{"a", 1}, {"b", 1}, {"c", 100}});
  add_rounds(shares, 100, {{"adopted", 0}});
  EXPECT_THAT(shares.slow(), IsEmpty());
  EXPECT_EQ(shares.units_of("c"), 3u);
  EXPECT_EQ(shares.units_of("adopted"), 100u);
}

TEST(HostShares, WhatIsRevokedDoesNotCountButWasTimed) {
  HostShares shares;
  add_rounds(shares, kRounds, {{"a", 50}, {"b", 10}});
  shares.discount("a", 1);
  EXPECT_EQ(shares.units_of("a"), kRounds - 1u);
  shares.clear_counts();
  shares.discount("a", 1);
  shares.count("b", 1);
  EXPECT_THAT(shares.hosts(), ElementsAre("b"));
  EXPECT_THAT(names(shares.slow()), ElementsAre("a"));
}

TEST(HostShares, PacesAreSaved) {
  HostShares shares;
  add_rounds(shares, kRounds, {{"a", 50}, {"b", 10}, {"c", 10}});
  HostShares::Saved saved;
  shares.save(saved);
  const HostShares again = HostShares::restored(saved);
  EXPECT_THAT(names(again.slow()), ElementsAre("a"));
  EXPECT_EQ(again.slow().front().slowness, shares.slow().front().slowness);
  // Those of older versions, and damaged ones, are not known.
  for (v1::JobCost::Host& host : saved) host.set_pace_variance(std::nan(""));
  EXPECT_THAT(HostShares::restored(saved).slow(), IsEmpty());
}

TEST(HostShares, UnitsOfPhasesCountAndAreNotTimed) {
  v1::JobSpec spec = square_spec("scene", 32);
  test::add_test_phases(spec, {2, 1});
  JobEntry entry{.id = "job",
                 .request_id = "",
                 .shape = JobShape::make(std::move(spec)).value(),
                 .past = std::nullopt,
                 .stats = {},
                 .hosts = {},
                 .units_by_sequence = {},
                 .past_revoked = {}};
  v1::UnitStats stats;
  stats.mutable_wall_time()->set_seconds(5);
  const std::uint32_t units = entry.shape->plan->unit_count(),
                      of_phases = entry.shape->plan->phases().unit_count();
  ASSERT_EQ(of_phases, 4u);
  for (std::uint32_t unit = 0; unit < units; ++unit) add_result(entry, {.first = unit}, "a", stats);
  HostShares::Saved saved;
  entry.hosts.save(saved);
  ASSERT_EQ(saved.size(), 1);
  EXPECT_EQ(saved[0].units(), units);
  EXPECT_EQ(saved[0].timed_units(), units - of_phases);

  // The same after a restart, which adds the rows up.
  JobRecord record;
  record.added.spec = entry.shape->spec.SerializeAsString();
  record.result_count = units;
  for (std::uint32_t unit = 0; unit < units; ++unit) {
    record.results.push_back({.units = {.first = unit},
                              .digest = wire::sha256_hex("blob"),
                              .stats = stats.SerializeAsString(),
                              .host = "a"});
  }
  HostShares::Saved again;
  entry_of(record).value().hosts.save(again);
  ASSERT_EQ(again.size(), 1);
  EXPECT_EQ(again[0].SerializeAsString(), saved[0].SerializeAsString());
}

}  // namespace
}  // namespace tessera::server
