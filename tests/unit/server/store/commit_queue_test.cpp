#include "store/commit_queue.h"

#include <gtest/gtest.h>

#include <future>
#include <semaphore>

namespace tessera::server {
namespace {

/// Lets the test decide when a commit ends, and how.
class SlowJournal final : public Journal {
 public:
  std::uint64_t epoch() const override { return 1; }
  absl::Status recover(const std::function<absl::Status(JobRecord)>&) override { return absl::OkStatus(); }
  absl::StatusOr<JobRecord> read_job(const std::string&) override { return JobRecord{}; }
  absl::StatusOr<std::vector<SchedulerEvent>> farm_events() override { return std::vector<SchedulerEvent>{}; }
  absl::Status commit(const std::vector<JournalEntry>& entries) override {
    begun_.release();
    ended_.acquire();
    sizes.push_back(entries.size());
    return result;
  }
  absl::StatusOr<std::string> read_result(const std::string&, std::uint64_t) override { return ""; }
  absl::StatusOr<std::vector<CoveredUnits>> read_units(const std::string&, std::uint64_t,
                                                       std::uint32_t) override {
    return std::vector<CoveredUnits>{};
  }

  void await_begin() { begun_.acquire(); }
  void end_commit() { ended_.release(); }

  std::vector<std::size_t> sizes;
  absl::Status result;

 private:
  std::counting_semaphore<> begun_{0}, ended_{0};
};

UnitDone unit(std::uint64_t sequence) {
  UnitDone done;
  done.sequence = sequence;
  done.payload = "1234567890";
  return done;
}

TEST(CommitQueue, WhatComesDuringACommitGoesTogetherIntoTheNext) {
  SlowJournal journal;
  std::vector<int> order;
  {
    CommitQueue queue(journal, base::machine_clock());
    queue.push({unit(1)}, [&](const absl::Status&) { order.push_back(1); });
    journal.await_begin();
    for (int i = 2; i <= 4; ++i) {
      queue.push({unit(static_cast<std::uint64_t>(i))},
                 [&order, i](const absl::Status&) { order.push_back(i); });
    }
    EXPECT_EQ(queue.waiting_bytes(), 4 * (sizeof(JournalEntry) + unit(1).payload.size()));
    journal.end_commit();
    journal.await_begin();
    journal.end_commit();
  }
  EXPECT_EQ(journal.sizes, (std::vector<std::size_t>{1, 3}));
  EXPECT_EQ(order, (std::vector<int>{1, 2, 3, 4}));
}

TEST(CommitQueue, ACallWithoutEntriesWaitsForThoseBefore) {
  SlowJournal journal;
  CommitQueue queue(journal, base::machine_clock());
  std::promise<void> first, barrier;
  queue.push({unit(1)}, [&](const absl::Status&) { first.set_value(); });
  queue.push({}, [&](const absl::Status&) { barrier.set_value(); });
  auto first_done = first.get_future(), barrier_done = barrier.get_future();
  journal.await_begin();
  EXPECT_EQ(barrier_done.wait_for(std::chrono::seconds(0)), std::future_status::timeout);
  journal.end_commit();
  barrier_done.wait();
  EXPECT_EQ(first_done.wait_for(std::chrono::seconds(0)), std::future_status::ready);
}

TEST(CommitQueue, ErrorsReachTheCallersAndAllWhoComeLater) {
  SlowJournal journal;
  journal.result = absl::InternalError("disk");
  std::vector<absl::Status> seen;
  const auto look = [&](const absl::Status& status) { seen.push_back(status); };
  {
    CommitQueue queue(journal, base::machine_clock());
    queue.push({unit(1)}, look);
    journal.await_begin();
    queue.push({}, look);  // asks whether the first is durable
    queue.push({unit(2)}, look);
    journal.end_commit();
  }
  EXPECT_EQ(seen, std::vector(3, journal.result));
  EXPECT_EQ(journal.sizes.size(), 1u);
}

}  // namespace
}  // namespace tessera::server
