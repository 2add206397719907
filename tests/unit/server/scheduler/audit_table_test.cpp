#include "scheduler/audit_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera::server {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

Audit audit_of(const std::string& host) { return {.opinions = {{host, 1}}}; }

TEST(AuditTable, ThoseThatAreOutAreNotLookedAt) {
  AuditTable audits;
  for (const std::uint32_t unit : {7u, 3u, 5u}) audits.put(unit, audit_of("a"));
  EXPECT_THAT(audits.waiting(), ElementsAre(3, 5, 7));
  audits.take(5);
  EXPECT_THAT(audits.waiting(), ElementsAre(3, 7));
  EXPECT_EQ(audits.out(), 1u);
  EXPECT_FALSE(audits.find(5)->lost);
  audits.give_back(5);
  EXPECT_THAT(audits.waiting(), ElementsAre(3, 5, 7));
  EXPECT_EQ(audits.out(), 0u);
  EXPECT_TRUE(audits.find(5)->is_over()) << "a second opinion is asked for once";
  audits.put(5, audit_of("b"));
  EXPECT_FALSE(audits.find(5)->lost);
}

TEST(AuditTable, WhatIsErasedIsNeitherOutNorWaiting) {
  AuditTable audits;
  for (std::uint32_t unit = 0; unit < 6; ++unit) audits.put(unit, audit_of(unit < 3 ? "a" : "b"));
  audits.take(1);
  audits.erase(1);
  audits.give_back(1);
  EXPECT_EQ(audits.find(1), nullptr);
  audits.take(4);
  audits.erase_if([](std::uint32_t unit, const Audit&) { return unit % 2 == 0; });
  EXPECT_THAT(audits.waiting(), ElementsAre(3, 5));
  EXPECT_EQ(audits.out(), 0u);
  audits.add_opinion(3, "c", 2);
  audits.drop_opinions([](const std::string& host) { return host == "b"; });
  EXPECT_THAT(audits.find(3)->opinions, ElementsAre(std::pair("c", 2u)));
  EXPECT_THAT(audits.find(5)->opinions, IsEmpty());
  audits.clear();
  EXPECT_TRUE(audits.empty());
  EXPECT_THAT(audits.waiting(), IsEmpty());
}

}  // namespace
}  // namespace tessera::server
