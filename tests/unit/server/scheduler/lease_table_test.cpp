#include "scheduler/lease_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera::server {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

Lease lease_of(std::uint64_t job, std::uint32_t unit, const std::string& worker, Time deadline) {
  return {.job = job,
          .units = {.first = unit},
          .attempt = 1,
          .epoch = 1,
          .worker = worker,
          .granted_at = Time{0},
          .deadline = deadline};
}

TEST(LeaseTable, FindsByUnitWorkerAndJob) {
  LeaseTable leases;
  const LeaseId a = leases.add(lease_of(0, 7, "w1", Time{10}));
  const LeaseId b = leases.add(lease_of(0, 7, "w2", Time{10}));
  const LeaseId c = leases.add(lease_of(1, 7, "w1", Time{10}));
  EXPECT_THAT(leases.of_unit(0, 7), ElementsAre(a, b));
  EXPECT_THAT(leases.of_worker("w1"), ElementsAre(a, c));
  EXPECT_THAT(leases.of_job(0), ElementsAre(a, b));
  EXPECT_EQ(leases.remove(a).worker, "w1");
  EXPECT_THAT(leases.of_unit(0, 7), ElementsAre(b));
  EXPECT_THAT(leases.of_worker("w1"), ElementsAre(c));
  EXPECT_EQ(leases.count_of_worker("w3"), 0u);
  EXPECT_THAT(leases.of_unit(5, 5), IsEmpty());
}

TEST(LeaseTable, ExpiresInOrderAndHonoursRefreshes) {
  LeaseTable leases;
  const LeaseId late = leases.add(lease_of(0, 0, "w", Time{30}));
  const LeaseId early = leases.add(lease_of(0, 1, "w", Time{10}));
  const LeaseId refreshed = leases.add(lease_of(0, 2, "w", Time{20}));
  leases.refresh(refreshed, Time{40});
  leases.refresh(late, Time{5});  // never earlier
  EXPECT_EQ(leases.expired(Time{9}), std::nullopt);
  EXPECT_EQ(leases.expired(Time{10}), early);
  leases.remove(early);
  EXPECT_EQ(leases.expired(Time{29}), std::nullopt);
  EXPECT_EQ(leases.expired(Time{30}), late);
  leases.remove(late);
  EXPECT_EQ(leases.expired(Time{39}), std::nullopt);
  EXPECT_EQ(leases.expired(Time{40}), refreshed);
}

}  // namespace
}  // namespace tessera::server
