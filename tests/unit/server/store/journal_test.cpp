#include "store/journal.h"

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

#include "absl/strings/str_cat.h"
#include "store/data_dir.h"
#include "store/sqlite/checked_pages.h"
#include "support/long_form.h"
#include "support/process/temp_dir.h"
#include "tessera/v1/job.pb.h"
#include "wire/digest.h"

namespace tessera::server {
namespace {

std::string payload_of(const std::string& job, std::uint64_t sequence) {
  return std::string(1000 + sequence % 7, static_cast<char>('a' + sequence % 26)) + job;
}

UnitDone unit_done(const std::string& job, std::uint64_t sequence) {
  const std::string payload = payload_of(job, sequence);
  return {.job = job,
          .sequence = sequence,
          .units = {.first = static_cast<std::uint32_t>(sequence * 3), .ranges = 1u << sequence % 3},
          .digest = wire::sha256_hex(payload),
          .payload = payload,
          .stats = absl::StrCat("stats ", sequence),
          .host = "host"};
}

JobAdded job_added(const std::string& id) {
  return {.id = id,
          .request_id = "request " + id,
          .spec = std::string("spec\0with a zero", 16),
          .generation = 2,
          .submitted_unix_ms = 1'700'000'000'000,
          .uploaded_bytes = 12};
}

std::vector<JobRecord> recover(Journal& journal) {
  std::vector<JobRecord> records;
  EXPECT_TRUE(journal
                  .recover([&](JobRecord record) {
                    records.push_back(std::move(record));
                    return absl::OkStatus();
                  })
                  .ok());
  return records;
}

/// Everything that is in it, or DataLoss.
absl::StatusOr<std::string> contents_of(const std::filesystem::path& directory) {
  auto journal = open_journal(directory);
  if (!journal.ok()) return journal.status();
  std::string all;
  const absl::Status status = (*journal)->recover([&](const JobRecord& record) {
    absl::StrAppend(&all, record.added.id, record.added.request_id, record.added.spec, record.isa,
                    record.ended.state);
    for (const JobRecord::Result& result : record.results) {
      absl::StrAppend(&all, result.units.first, result.units.ranges, result.digest, result.stats, result.host,
                      result.bytes, " ");
    }
    for (const SchedulerEvent& event : record.events)
      absl::StrAppend(&all, event.kind, event.value, event.text, " ");
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  const auto events = (*journal)->farm_events();
  if (!events.ok()) return events.status();
  for (const SchedulerEvent& event : *events) absl::StrAppend(&all, event.kind, event.host, event.text, " ");
  return all;
}

class JournalTest : public testing::Test {
 protected:
  JournalTest() { EXPECT_TRUE(DataDir::open(directory_.path()).ok()); }
  std::unique_ptr<Journal> open() { return open_journal(directory_.path()).value(); }
  std::filesystem::path results(const std::string& job) const { return directory_.path() / "results" / job; }
  void change_tables(const std::string& statements) const {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open_v2((directory_.path() / "journal.sqlite").c_str(), &database,
                              SQLITE_OPEN_READWRITE, checked_pages_vfs()),
              SQLITE_OK);
    ASSERT_EQ(sqlite3_exec(database, absl::StrCat("PRAGMA locking_mode = EXCLUSIVE; ", statements).c_str(),
                           nullptr, nullptr, nullptr),
              SQLITE_OK);
    sqlite3_close(database);
  }

  support::TempDir directory_;
};

TEST_F(JournalTest, CopiesResultsOfOtherJobs) {
  for (int start = 0; start < 2; ++start) {
    auto journal = open();
    if (start == 0) {
      ASSERT_TRUE(
          journal->commit({job_added("a"), unit_done("a", 1), unit_done("a", 2), JobEnded{"a", 3, "", 1}})
              .ok());
      UnitDone copy = unit_done("b", 1);
      copy.payload.clear();
      copy.from_job = "a";
      copy.from_sequence = 2;
      ASSERT_TRUE(journal->commit({job_added("b"), copy, unit_done("b", 2)}).ok());
      ASSERT_TRUE(journal->commit({JobPruned{"a"}}).ok());
    } else {
      EXPECT_EQ(recover(*journal).size(), 1u);
    }
    EXPECT_EQ(journal->read_result("b", 1).value(), payload_of("a", 2))
        << "whatever becomes of the other job";
    EXPECT_EQ(journal->read_result("b", 2).value(), payload_of("b", 2));
    EXPECT_EQ(journal->read_job("a").status().code(), absl::StatusCode::kNotFound);
    const JobRecord record = journal->read_job("b").value();
    ASSERT_EQ(record.results.size(), 2u);
    EXPECT_EQ(record.results[0].bytes, payload_of("a", 2).size());
    EXPECT_EQ(record.results[1].bytes, payload_of("b", 2).size());
    EXPECT_EQ(record.results[1].digest, unit_done("b", 2).digest);
    EXPECT_EQ(record.result_bytes, record.results[0].bytes + record.results[1].bytes);
  }
}

TEST_F(JournalTest, ACopyOfWhatIsNotThereIsAnError) {
  auto journal = open();
  UnitDone copy = unit_done("b", 1);
  copy.from_job = "a";
  copy.from_sequence = 1;
  EXPECT_FALSE(journal->commit({job_added("b"), copy}).ok());
}

TEST_F(JournalTest, RemembersEverything) {
  {
    auto journal = open();
    EXPECT_EQ(journal->epoch(), 1u);
    EXPECT_TRUE(recover(*journal).empty());
    ASSERT_TRUE(journal->commit({job_added("b"), job_added("a")}).ok());
    ASSERT_TRUE(journal->commit({unit_done("b", 1), JobBound{"a", "avx2"}, unit_done("b", 2)}).ok());
    ASSERT_TRUE(journal->commit({unit_done("a", 1), JobEnded{"a", 5, "no more", 17}}).ok());
    EXPECT_EQ(journal->read_result("b", 2).value(), payload_of("b", 2));
    EXPECT_EQ(journal->read_result("a", 1).value(), payload_of("a", 1));
  }
  auto journal = open();
  EXPECT_EQ(journal->epoch(), 2u);
  const std::vector<JobRecord> records = recover(*journal);
  ASSERT_EQ(records.size(), 2u);
  EXPECT_EQ(records[0].added.id, "b") << "in the order of submission";
  EXPECT_EQ(records[0].added.request_id, "request b");
  EXPECT_EQ(records[0].added.spec, job_added("b").spec);
  EXPECT_EQ(records[0].added.generation, 2u);
  EXPECT_EQ(records[0].added.submitted_unix_ms, 1'700'000'000'000);
  EXPECT_EQ(records[0].added.uploaded_bytes, 12u);
  EXPECT_EQ(records[0].ended.state, 0);
  ASSERT_EQ(records[0].results.size(), 2u);
  EXPECT_EQ(records[0].results[1].units, (CoveredUnits{.first = 6, .ranges = 4}));
  EXPECT_EQ(records[0].results[1].digest, wire::sha256_hex(payload_of("b", 2)));
  EXPECT_EQ(records[0].results[1].stats, "stats 2");
  EXPECT_EQ(records[1].isa, "avx2");
  EXPECT_EQ(records[1].ended.state, 5);
  EXPECT_EQ(records[1].ended.error, "no more");
  EXPECT_EQ(records[1].ended.finished_unix_ms, 17);
  for (std::uint64_t sequence : {1, 2})
    EXPECT_EQ(journal->read_result("b", sequence).value(), payload_of("b", sequence));
  EXPECT_EQ(journal->read_result("a", 1).value(), payload_of("a", 1));
}

TEST_F(JournalTest, InMemoryIsTheSameWithoutAFile) {
  auto journal = open_journal({}).value();
  EXPECT_TRUE(recover(*journal).empty());
  ASSERT_TRUE(journal->commit({job_added("a"), unit_done("a", 1), unit_done("a", 2)}).ok());
  ASSERT_TRUE(journal->commit({unit_done("a", 3), JobEnded{"a", 3, "", 1}}).ok());
  for (std::uint64_t sequence : {1, 2, 3})
    EXPECT_EQ(journal->read_result("a", sequence).value(), payload_of("a", sequence));
}

TEST_F(JournalTest, ThereIsNothingBeyondTheLastResult) {
  auto journal = open();
  ASSERT_TRUE(journal->commit({job_added("a"), unit_done("a", 1)}).ok());
  for (std::uint64_t sequence : {0, 2}) {
    EXPECT_EQ(journal->read_result("a", sequence).status().code(), absl::StatusCode::kOutOfRange);
  }
  EXPECT_EQ(journal->read_result("b", 1).status().code(), absl::StatusCode::kOutOfRange);
}

TEST_F(JournalTest, AJobThatIsOverIsReadFromTheDisk) {
  constexpr std::uint64_t kResults = 2500;  // more than are looked up at a time
  std::vector<JournalEntry> entries = {job_added("a")};
  for (std::uint64_t sequence = 1; sequence <= kResults; ++sequence)
    entries.push_back(unit_done("a", sequence));
  auto journal = open();
  ASSERT_TRUE(journal->commit(entries).ok());
  ASSERT_TRUE(journal->commit({JobEnded{"a", v1::DONE, "", 17}, JobStats{"a", kResults, "all of it"}}).ok());
  const auto expect_results = [&] {
    for (const std::uint64_t sequence :
         {kResults, std::uint64_t{1}, std::uint64_t{1024}, std::uint64_t{1025}, kResults}) {
      EXPECT_EQ(journal->read_result("a", sequence).value(), payload_of("a", sequence));
    }
    EXPECT_EQ(journal->read_result("a", kResults + 1).status().code(), absl::StatusCode::kOutOfRange);
    EXPECT_EQ(journal->read_units("a", 1023, 2).value(),
              (std::vector<CoveredUnits>{unit_done("a", 1024).units, unit_done("a", 1025).units}));
    EXPECT_TRUE(journal->read_units("a", kResults, 10).value().empty());
  };
  expect_results();
  journal.reset();
  journal = open();
  const std::vector<JobRecord> records = recover(*journal);
  EXPECT_TRUE(records[0].results.empty()) << "a start takes no longer for jobs that are over";
  EXPECT_EQ(records[0].result_count, kResults);
  EXPECT_EQ(records[0].stats.stats, "all of it");
  expect_results();
  // A job that goes on, after a page of it was read.
  ASSERT_TRUE(journal->commit({JobReopened{"a"}, unit_done("a", kResults + 1)}).ok());
  for (const std::uint64_t sequence :
       {kResults + 1, std::uint64_t{1}, kResults, std::uint64_t{1024}, kResults + 1}) {
    EXPECT_EQ(journal->read_result("a", sequence).value(), payload_of("a", sequence));
  }
  // Another job can still take its results over.
  UnitDone copy = unit_done("b", 1);
  copy.from_job = "a";
  copy.from_sequence = 1500;
  ASSERT_TRUE(journal->commit({job_added("b"), copy}).ok());
  EXPECT_EQ(journal->read_result("b", 1).value(), payload_of("a", 1500));
}

TEST_F(JournalTest, WhatIsAddedUpIsNotReadAgain) {
  auto journal = open();
  ASSERT_TRUE(
      journal->commit({job_added("a"), unit_done("a", 1), unit_done("a", 2), JobStats{"a", 2, "of two"}})
          .ok());
  ASSERT_TRUE(journal->commit({unit_done("a", 3)}).ok());
  journal.reset();
  const JobRecord record = recover(*open())[0];
  EXPECT_EQ(record.stats.results, 2u);
  EXPECT_EQ(record.stats.stats, "of two");
  ASSERT_EQ(record.results.size(), 3u);
  EXPECT_EQ(record.results[1].stats, "");
  EXPECT_EQ(record.results[2].stats, "stats 3");
}

TEST_F(JournalTest, ACommitIsAllOrNothingAndAnErrorIsTheEnd) {
  {
    auto journal = open();
    ASSERT_TRUE(journal->commit({job_added("a"), unit_done("a", 1)}).ok());
    EXPECT_FALSE(journal->commit({unit_done("a", 2), job_added("a")}).ok()) << "the id is taken";
    EXPECT_FALSE(journal->commit({unit_done("a", 2)}).ok());
  }
  auto journal = open();
  EXPECT_EQ(recover(*journal)[0].results.size(), 1u);
  ASSERT_TRUE(journal->commit({unit_done("a", 2)}).ok());
  EXPECT_EQ(journal->read_result("a", 2).value(), payload_of("a", 2));
}

TEST_F(JournalTest, PayloadsWithoutARowAreOverwritten) {
  {
    auto journal = open();
    ASSERT_TRUE(journal->commit({job_added("a"), unit_done("a", 1)}).ok());
  }
  std::ofstream(results("a"), std::ios::app) << "half of a payload whose commit never";
  auto journal = open();
  ASSERT_EQ(recover(*journal)[0].results.size(), 1u);
  ASSERT_TRUE(journal->commit({unit_done("a", 2)}).ok());
  EXPECT_EQ(journal->read_result("a", 1).value(), payload_of("a", 1));
  EXPECT_EQ(journal->read_result("a", 2).value(), payload_of("a", 2));
}

TEST_F(JournalTest, MissingPayloadsAreNoticed) {
  ASSERT_TRUE(open()->commit({job_added("a"), unit_done("a", 1), unit_done("a", 2)}).ok());
  EXPECT_EQ(recover(*open())[0].whole_results, 2u);
  std::filesystem::resize_file(results("a"), 1500);
  {
    auto journal = open();
    EXPECT_EQ(recover(*journal)[0].whole_results, 1u);
    EXPECT_EQ(journal->read_result("a", 1).value(), payload_of("a", 1));
    EXPECT_EQ(journal->read_result("a", 2).status().code(), absl::StatusCode::kDataLoss);
  }
  std::filesystem::remove(results("a"));
  auto journal = open();
  EXPECT_EQ(recover(*journal)[0].whole_results, 0u);
  EXPECT_EQ(journal->read_result("a", 1).status().code(), absl::StatusCode::kNotFound);
}

TEST_F(JournalTest, ACopyOfWhatIsLostIsLostToo) {
  ASSERT_TRUE(open()->commit({job_added("a"), unit_done("a", 1)}).ok());
  std::filesystem::resize_file(results("a"), 500);
  auto journal = open();
  recover(*journal);
  UnitDone copy = unit_done("b", 1);
  copy.payload.clear();
  copy.from_job = "a";
  copy.from_sequence = 1;
  JobAdded added = job_added("b");
  ASSERT_TRUE(journal->commit({added, copy}).ok()) << "the coordinator goes on";
  EXPECT_EQ(journal->read_result("b", 1).value(), "");
}

TEST_F(JournalTest, DamageIsAnErrorThatSaysSoWhereThereAreNoLogs) {
  ASSERT_TRUE(open()->commit({job_added("a")}).ok());
  const auto damage = [&] {
    std::filesystem::remove(directory_.path() / "journal.sqlite-wal");
    std::ofstream(directory_.path() / "journal.sqlite") << std::string(5000, 'x');
  };
  damage();
  EXPECT_EQ(recover(*open())[0].added.spec, job_added("a").spec) << "made anew from the logs";
  EXPECT_TRUE(std::filesystem::exists(directory_.path() / "journal.sqlite.damaged"));
  damage();
  std::filesystem::remove(directory_.path() / "farm.log");
  std::filesystem::remove(results("a.log"));
  EXPECT_EQ(open_journal(directory_.path()).status().code(), absl::StatusCode::kDataLoss);
}

TEST_F(JournalTest, AFlippedBitInAPageIsNoticedAndTheJournalMadeAnew) {
  {
    auto journal = open();
    for (const char* id : {"a", "b"}) {
      std::vector<JournalEntry> entries{job_added(id)};
      for (std::uint64_t sequence = 1; sequence <= 40; ++sequence) entries.push_back(unit_done(id, sequence));
      entries.push_back(
          SchedulerEvent{.job = id, .kind = 12, .unit = 0, .value = 3, .host = "", .text = "a note"});
      ASSERT_TRUE(journal->commit(entries).ok());
    }
    ASSERT_TRUE(
        journal
            ->commit({SchedulerEvent{.job = "", .kind = 10, .unit = 0, .value = 0, .host = "h", .text = "w"}})
            .ok());
  }
  const std::string whole = contents_of(directory_.path()).value();
  const std::filesystem::path path = directory_.path() / "journal.sqlite";
  const std::uint64_t size = std::filesystem::file_size(path);
  const support::TempDir kept;
  constexpr auto kAll =
      std::filesystem::copy_options::recursive | std::filesystem::copy_options::overwrite_existing;
  std::filesystem::copy(directory_.path(), kept.path(), kAll);
  // Bytes of the header, and some of all others; TESSERA_BYTE_STRIDE=1 takes every one, and an hour.
  const std::uint64_t stride = test::how_often("TESSERA_BYTE_STRIDE", 997, 97);
  std::uint64_t made_anew = 0, tried = 0;
  for (std::uint64_t at = 0; at < size; at += at < 100 ? 1 + stride / 100 : stride) {
    std::filesystem::remove_all(directory_.path());
    std::filesystem::copy(kept.path(), directory_.path(), kAll);
    {
      std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
      file.seekg(static_cast<std::streamoff>(at));
      const int byte = file.get();
      file.seekp(static_cast<std::streamoff>(at)).put(static_cast<char>(byte ^ (1 << at % 8)));
    }
    absl::StatusOr<std::string> found = contents_of(directory_.path());
    if (absl::IsDataLoss(found.status())) found = contents_of(directory_.path());
    ASSERT_TRUE(found.ok()) << "byte " << at << ": " << found.status();
    EXPECT_EQ(*found, whole) << "byte " << at;
    ++tried;
    made_anew += std::filesystem::exists(path.string() + ".damaged");
  }
  EXPECT_GT(made_anew, tried / 2) << "the rest are pages that nothing reads";
}

TEST_F(JournalTest, AJournalWithoutChecksumsGetsThem) {
  const std::filesystem::path path = directory_.path() / "journal.sqlite";
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(database,
                         "PRAGMA journal_mode = WAL; CREATE TABLE old (value); INSERT INTO old VALUES (7)",
                         nullptr, nullptr, nullptr),
            SQLITE_OK);
  sqlite3_close(database);
  ASSERT_TRUE(open()->commit({job_added("a")}).ok());
  std::ifstream file(path, std::ios::binary);
  EXPECT_EQ(file.seekg(20).get(), 8);
  EXPECT_EQ(recover(*open())[0].added.id, "a");
  ASSERT_EQ(sqlite3_open_v2(path.c_str(), &database, SQLITE_OPEN_READWRITE, checked_pages_vfs()), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(database, "PRAGMA locking_mode = EXCLUSIVE; SELECT 1 / (value = 7) FROM old",
                         nullptr, nullptr, nullptr),
            SQLITE_OK);
  sqlite3_close(database);
}

TEST_F(JournalTest, OtherFormatsAreRefused) {
  open();
  for (const int format : {4, 6}) {
    SCOPED_TRACE(format);
    change_tables(absl::StrCat("UPDATE meta SET value = ", format, " WHERE key = 'format'"));
    const absl::Status status = open_journal(directory_.path()).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
    EXPECT_NE(status.message().find(absl::StrCat("has format ", format)), std::string::npos) << status;
  }
}

// A child commits and says so on a pipe, until it is killed in the middle; whatever it had said must be
// there.
TEST_F(JournalTest, WhatWasAcknowledgedSurvivesKill9) {
  for (int round = 0; round < 5; ++round) {
    int ends[2];
    ASSERT_EQ(pipe(ends), 0);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      auto journal = open_journal(directory_.path()).value();
      if (recover(*journal).empty() && !journal->commit({job_added("a")}).ok()) _exit(1);
      // Entries that the last child had committed without having said so count as well.
      std::uint64_t sequence = 0;
      while (journal->read_result("a", sequence + 1).ok()) ++sequence;
      while (true) {
        if (!journal->commit({unit_done("a", sequence + 1), unit_done("a", sequence + 2)}).ok()) _exit(1);
        sequence += 2;
        if (write(ends[1], &sequence, sizeof(sequence)) != sizeof(sequence)) _exit(1);
      }
    }
    close(ends[1]);
    std::uint64_t acknowledged = 0;
    // Killed after a different number of commits each time, wherever the child is by then.
    for (int i = 0; i < 5 + 4 * round; ++i) {
      ASSERT_EQ(read(ends[0], &acknowledged, sizeof(acknowledged)),
                static_cast<ssize_t>(sizeof(acknowledged)));
    }
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    for (std::uint64_t more; read(ends[0], &more, sizeof(more)) == sizeof(more);) acknowledged = more;
    close(ends[0]);

    auto journal = open();
    const std::vector<JobRecord> records = recover(*journal);
    ASSERT_EQ(records.size(), 1u);
    ASSERT_GE(records[0].results.size(), acknowledged);
    EXPECT_EQ(records[0].results.size() % 2, 0u) << "half a commit";
    for (std::uint64_t sequence = 1; sequence <= records[0].results.size(); ++sequence) {
      EXPECT_EQ(records[0].results[sequence - 1].units, unit_done("a", sequence).units);
      ASSERT_EQ(journal->read_result("a", sequence).value(), payload_of("a", sequence));
    }
  }
}

}  // namespace
}  // namespace tessera::server
