#include "command/report/job_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_split.h"
#include "command/jobs/job_selection.h"
#include "command/report/phase.h"
#include "command/report/table.h"

namespace tessera::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

std::vector<std::string> lines_of(const std::string& text) {
  return absl::StrSplit(text, '\n', absl::SkipEmpty());
}

TEST(Table, IsAlignedAndLeavesOutWhatIsEmpty) {
  Table table{{{"ID"}, {"N", /*right=*/true}, {"NOTHING"}, {"NAME"}}};
  table.add({"a", "5", "", "kitchen"});
  table.add({"bcd", "10", "", "b\xc3\xa4r"});
  EXPECT_EQ(table.text(0),
            "ID    N  NAME\n"
            "a     5  kitchen\n"
            "bcd  10  b\xc3\xa4r\n");
}

TEST(Table, FitsTheTerminalByCuttingNames) {
  Table table{{{"ID"}, {"USER", false, /*shrinks=*/true}, {"NAME", false, true}}};
  table.add({"4f0c2a11", "alice", "a very long name of a scene, with b\xc3\xa4ren"});
  for (std::size_t width = 30; width < 60; ++width) {
    for (const std::string& line : lines_of(table.text(width))) EXPECT_LE(line.size(), width + 1) << line;
  }
  EXPECT_EQ(lines_of(table.text(40))[1], "4f0c2a11  alice  a very long name of ...");
}

TEST(Table, ShowsControlCharactersInsteadOfObeyingThem) {
  Table table{{{"NAME"}}};
  table.add({"red\x1b[31m\r\nroot\xc2\x9b"});
  EXPECT_EQ(lines_of(table.text(0))[1], "red\\x1b[31m\\x0d\\nroot\\xc2\\x9b");
}

v1::JobStatus running_job() {
  v1::JobStatus job;
  job.set_job_id("4f0c2a11");
  job.set_name("kitchen");
  job.set_user("alice");
  job.set_state(v1::RUNNING);
  job.set_units_total(300);
  job.set_units_done(299);
  job.set_elapsed_ms(61'000);
  job.set_left_ms(4'000);
  job.set_workers(7);
  return job;
}

TEST(JobTable, SaysHowFarAJobIsAndHowLongItTakes) {
  v1::JobStatus paused = running_job();
  paused.set_job_id("91be07aa");
  paused.set_paused(true);
  paused.set_left_ms(0);
  paused.set_priority(5);
  paused.set_failures(2);
  EXPECT_THAT(
      lines_of(jobs_table({running_job(), paused}, 0)),
      ElementsAre("ID        STATE    DONE  ELAPSED  LEFT  WORKERS  PRIORITY  TROUBLE   USER   NAME",
                  "4f0c2a11  running  99 %     1:01  0:04        7                      alice  kitchen",
                  "91be07aa  paused   99 %     1:01              7         5  2 failed  alice  kitchen"));
  EXPECT_EQ(jobs_table({}, 0), "there are no jobs\n");
}

TEST(JobTable, SaysWhoWorksOnWhat) {
  v1::WorkerStatus worker;
  worker.set_name("render7:4711");
  worker.set_host("render7");
  worker.set_threads(8);
  worker.set_leases(3);
  worker.set_units_done(120);
  worker.set_last_seen_ms_ago(300);
  worker.set_isa("avx2");
  worker.add_tags("big");
  worker.add_tags("ssd");
  v1::WorkerJob& job = *worker.add_jobs();
  job.set_job_id("4f0c2a11");
  job.set_name("kitchen");
  job.set_leases(2);
  worker.add_jobs()->set_leases(1);  // not for the caller's eyes
  v1::WorkerStatus liar = worker;
  liar.set_name("liar:1");
  liar.set_quarantine("two hosts agree against it");
  EXPECT_THAT(
      lines_of(workers_table({worker, liar}, 0)),
      ElementsAre("NAME          STATE       THREADS  UNITS  DONE   SEEN  ARITHMETIC  TAGS     WORKS ON",
                  "render7:4711  working           8      3   120  0.3 s  avx2        big,ssd  4f0c2a11 "
                  "kitchen (2), of others (1)",
                  "liar:1        quarantine        8      3   120  0.3 s  avx2        big,ssd  4f0c2a11 "
                  "kitchen (2), of others (1)",
                  "liar:1: host render7 is in quarantine: two hosts agree against it"));
}

TEST(JobTable, AJobSaysWhoRendersIt) {
  v1::GetJobResponse response;
  *response.mutable_status() = running_job();
  v1::JobWorker& worker = *response.add_workers();
  worker.set_name("render7:4711");
  worker.set_leases(2);
  response.mutable_spec()->mutable_farm()->add_required_tags("big");
  const std::string text = job_text(response);
  EXPECT_THAT(text, HasSubstr("done        99 %, 299 of 300 units, 0 at work\n"));
  EXPECT_THAT(text, HasSubstr("since       1:01, 0:04 left\n"));
  EXPECT_THAT(text, HasSubstr("worker      render7:4711, 2 units\n"));
  EXPECT_THAT(text, HasSubstr("requires    big\n"));
  response.mutable_status()->set_name("one\ntwo");
  EXPECT_THAT(job_text(response), HasSubstr("name        one\\ntwo\n"));
}

TEST(JobTable, AFailureHasTheWorkersLog) {
  v1::GetJobResponse response;
  v1::JobStatus& status = *response.mutable_status();
  status = running_job();
  v1::UnitFailure failure;
  failure.set_host("render7");
  failure.set_message("no texture");
  failure.add_log("12:00 [warning] the disk is full");
  failure.add_log("12:01 [error] unit 7\x1b[2J");
  v1::SetAsideUnit& aside = *status.add_set_aside();
  aside.mutable_unit()->set_index(7);
  *aside.add_failures() = failure;
  v1::FailedUnit& latest = *status.add_latest_failures();
  latest.set_unit_index(7);
  *latest.mutable_failure() = failure;
  status.set_failures(1);
  const std::string text = job_text(response);
  const std::string log =
      "              | 12:00 [warning] the disk is full\n"
      "              | 12:01 [error] unit 7\\x1b[2J\n";
  EXPECT_THAT(text, HasSubstr("            on render7: no texture\n" + log));
  EXPECT_EQ(text.find(log), text.rfind(log)) << "told twice";
}

TEST(JobSelection, ABeginningNamesAJobWhereItIsUnique) {
  const std::vector<std::string> all{"4f0c2a11", "4f0d0000", "91be07aa"};
  EXPECT_EQ(find_job_id(all, "9").value(), "91be07aa");
  EXPECT_EQ(find_job_id(all, "4f0c2a11").value(), "4f0c2a11");
  const absl::Status several = find_job_id(all, "4f0").status();
  EXPECT_TRUE(absl::IsInvalidArgument(several));
  EXPECT_THAT(std::string{several.message()}, HasSubstr("2 jobs begin with 4f0"));
  const absl::Status none = find_job_id(all, "4f0c2a12").status();
  EXPECT_TRUE(absl::IsNotFound(none));
  EXPECT_THAT(std::string{none.message()}, HasSubstr("did you mean '4f0c2a11'"));
  EXPECT_TRUE(absl::IsNotFound(find_job_id(all, "").status()));
}

TEST(JobSelection, AFilterTakesUsersAndStates) {
  v1::JobStatus job = running_job();
  EXPECT_TRUE(matches({}, job));
  EXPECT_TRUE(matches({.user = "alice", .state = "running"}, job));
  EXPECT_FALSE(matches({.user = "bob", .state = ""}, job));
  job.set_paused(true);
  EXPECT_FALSE(matches({.user = "", .state = "running"}, job));
  EXPECT_TRUE(matches({.user = "", .state = "paused"}, job));
}

TEST(Phase, IsToldWithItsDetailAndTime) {
  EXPECT_EQ(format_phase("kitchen", "reading", "", 5.2), "kitchen: reading, 0:06");
  EXPECT_EQ(format_phase("kitchen", "uploading", format_bytes(12'345'678, 40'100'000), 1),
            "kitchen: uploading, 12.3 of 40.1 MB, 0:01");
  EXPECT_EQ(format_bytes(0, 2'500'000'000), "0.0 of 2.5 GB");
}

}  // namespace
}  // namespace tessera::client
