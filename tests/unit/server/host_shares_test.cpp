// Who is slow with a job.
#include "service/host_shares.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera::server {
namespace {

using std::chrono::seconds;

void add(HostShares& shares, const std::string& host, int units, seconds each) {
  for (int i = 0; i < units; ++i) {
    shares.count(host, 1);
    shares.time(host, each);
  }
}

std::vector<std::string> names(const std::vector<HostShare>& shares) {
  std::vector<std::string> hosts;
  for (const HostShare& share : shares) hosts.push_back(share.host);
  return hosts;
}

TEST(HostShares, NameHostsThatTakeTwiceTheMedian) {
  HostShares shares;
  add(shares, "a", 10, seconds{10});
  add(shares, "b", 10, seconds{11});
  add(shares, "c", 10, seconds{9});
  EXPECT_TRUE(shares.slow().empty());
  add(shares, "slow", 4, seconds{25});
  add(shares, "slower", 5, seconds{100});
  EXPECT_EQ(shares.usual(), seconds{11});
  EXPECT_THAT(names(shares.slow()), testing::ElementsAre("slower", "slow"));
  EXPECT_EQ(shares.slow().front().units, 5u);
  EXPECT_EQ(shares.slow().front().mean, seconds{100});
}

TEST(HostShares, OfTwoTheFasterIsUsual) {
  HostShares shares;
  add(shares, "a", 4, seconds{30});
  EXPECT_TRUE(shares.slow().empty());
  add(shares, "b", 4, seconds{10});
  EXPECT_THAT(names(shares.slow()), testing::ElementsAre("a"));
}

TEST(HostShares, FewUnitsSayNothing) {
  HostShares shares;
  add(shares, "a", 4, seconds{1});
  add(shares, "b", 4, seconds{1});
  add(shares, "c", 3, seconds{100});
  add(shares, "adopted", 100, seconds{0});
  EXPECT_TRUE(shares.slow().empty());
  EXPECT_EQ(shares.units_of("c"), 3u);
  EXPECT_EQ(shares.units_of("adopted"), 100u);
}

TEST(HostShares, WhatIsRevokedDoesNotCountButWasTimed) {
  HostShares shares;
  add(shares, "a", 4, seconds{3});
  add(shares, "b", 4, seconds{1});
  shares.discount("a", 1);
  EXPECT_EQ(shares.units_of("a"), 3u);
  shares.clear_counts();
  shares.discount("a", 1);
  shares.count("b", 1);
  EXPECT_THAT(shares.hosts(), testing::ElementsAre("b"));
  EXPECT_THAT(names(shares.slow()), testing::ElementsAre("a"));
}

}  // namespace
}  // namespace tessera::server
