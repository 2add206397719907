// What needs no farm of its own to be shown; the rest is in tests/scenario.
#include "scheduler/scheduler.h"

#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"

namespace tessera::server {
namespace {

TEST(Scheduler, LargeFarmsAreHeardOfLessOftenAndAreMorePatient) {
  Scheduler scheduler({.heartbeat_interval = Time{1000}, .lease_timeout = Time{8000}});
  const auto grow = [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      EXPECT_TRUE(scheduler
                      .register_worker({.id = absl::StrCat(i),
                                        .name = "",
                                        .build = "",
                                        .isa = "avx2",
                                        .supported_isas = {"avx2"},
                                        .threads = 1,
                                        .host = absl::StrCat(i),
                                        .tags = {}},
                                       Time{0})
                      .ok());
    }
  };
  grow(0, 2000);
  EXPECT_EQ(scheduler.heartbeat_interval(), Time{1000});
  EXPECT_TRUE(scheduler.advance(Time{7999}).lost_workers.empty());
  grow(2000, 6000);
  EXPECT_EQ(scheduler.heartbeat_interval(), Time{3000});
  EXPECT_TRUE(scheduler.advance(Time{7999}).lost_workers.empty());
  grow(6000, 20'000);
  EXPECT_EQ(scheduler.heartbeat_interval(), Time{5000}) << "and no less often, or dead workers are noticed too late";
  EXPECT_TRUE(scheduler.advance(Time{12'499}).lost_workers.empty());
  EXPECT_EQ(scheduler.advance(Time{12'500}).lost_workers.size(), 20'000u);
  EXPECT_EQ(scheduler.heartbeat_interval(), Time{1000});
}

}  // namespace
}  // namespace tessera::server
