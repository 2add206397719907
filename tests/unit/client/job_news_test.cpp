#include "command/jobs/job_news.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera::client {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

v1::JobStatus status_with(std::uint64_t failures, int listed) {
  v1::JobStatus status;
  status.set_job_id("4f0c2a11");
  status.set_failures(failures);
  for (int i = 0; i < listed; ++i) {
    v1::FailedUnit& failed = *status.add_latest_failures();
    failed.set_unit_index(static_cast<std::uint32_t>(i));
    failed.mutable_failure()->set_host("render7");
    failed.mutable_failure()->set_message("no \x1b[31mtexture");
  }
  return status;
}

TEST(JobNews, APauseIsToldOnceAndSoIsItsEnd) {
  JobNews news;
  v1::JobStatus status = status_with(0, 0);
  EXPECT_THAT(news.lines(status), IsEmpty());
  status.set_paused(true);
  EXPECT_THAT(news.lines(status),
              ElementsAre("job 4f0c2a11 is paused; it goes on after: tessera resume 4f0c2a11"));
  EXPECT_THAT(news.lines(status), IsEmpty());
  status.set_paused(false);
  EXPECT_THAT(news.lines(status), ElementsAre("job 4f0c2a11 goes on"));
}

TEST(JobNews, AUnitThatFailsIsToldOnceAndEscaped) {
  JobNews news;
  EXPECT_THAT(news.lines(status_with(1, 1)), ElementsAre("unit 0 failed on render7: no \\x1b[31mtexture"));
  EXPECT_THAT(news.lines(status_with(1, 1)), IsEmpty());
  v1::JobStatus lost = status_with(2, 2);
  lost.mutable_latest_failures(1)->mutable_failure()->set_lost(true);
  EXPECT_THAT(news.lines(lost), ElementsAre("unit 1 was lost with a worker on render7"));
}

TEST(JobNews, ARunThatIsLostIsToldAsOne) {
  v1::JobStatus status = status_with(1, 1);
  status.mutable_latest_failures(0)->set_ranges(16);
  EXPECT_THAT(JobNews().lines(status),
              ElementsAre("the run of 16 units from 0 failed on render7: no \\x1b[31mtexture"));
  status.mutable_latest_failures(0)->mutable_failure()->set_lost(true);
  EXPECT_THAT(JobNews().lines(status),
              ElementsAre("the run of 16 units from 0 was lost with a worker on render7"));
}

TEST(JobNews, ManyFailuresAtOnceAreCounted) {
  JobNews news;
  const std::vector<std::string> lines = news.lines(status_with(1000, 16));
  ASSERT_EQ(lines.size(), 4u);
  EXPECT_EQ(lines[0], "997 units failed before; tessera job 4f0c2a11 tells what is known");
  EXPECT_EQ(lines[3], "unit 15 failed on render7: no \\x1b[31mtexture");
  EXPECT_THAT(news.lines(status_with(2, 2)), IsEmpty())
      << "a coordinator that was started again counts from 0";
  EXPECT_EQ(news.lines(status_with(3, 3)).size(), 1u);
}

}  // namespace
}  // namespace tessera::client
