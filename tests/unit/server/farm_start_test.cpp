// A farm that starts on a journal that takes its time.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "requests.h"
#include "service/farm.h"

namespace tessera::server {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;

/// Has one job, cancelled long ago, and is busy with the next when the farm's clock ticks.
class SlowJournal : public Journal {
 public:
  std::uint64_t epoch() const override { return 2; }

  absl::Status recover(const std::function<absl::Status(JobRecord)>& visit) override {
    const v1::JobSpec spec = square_spec("a scene", 16);
    JobRecord record;
    record.added = {.id = "old", .request_id = "request", .spec = spec.SerializeAsString()};
    record.ended = {.id = "old", .state = v1::CANCELLED, .error = "", .finished_unix_ms = 1};
    absl::Status status = visit(std::move(record));
    std::this_thread::sleep_for(milliseconds{600});
    recovered_ = true;
    return status;
  }

  absl::Status commit(const std::vector<JournalEntry>& entries) override {
    if (!recovered_) committed_early_ = true;
    for (const JournalEntry& entry : entries) {
      if (std::holds_alternative<JobPruned>(entry)) pruned_ = true;
    }
    return absl::OkStatus();
  }

  absl::StatusOr<JobRecord> read_job(const std::string& job) override { return absl::NotFoundError(job); }
  absl::StatusOr<std::vector<SchedulerEvent>> farm_events() override { return std::vector<SchedulerEvent>(); }
  absl::StatusOr<std::string> read_result(const std::string& job, std::uint64_t) override {
    return absl::OutOfRangeError(job);
  }
  absl::StatusOr<std::vector<CoveredUnits>> read_units(const std::string&, std::uint64_t, std::uint32_t) override {
    return std::vector<CoveredUnits>();
  }

  bool committed_early() const { return committed_early_; }
  bool pruned() const { return pruned_; }

 private:
  std::atomic<bool> recovered_ = false, committed_early_ = false, pruned_ = false;
};

TEST(FarmStart, NothingIsPrunedBeforeAllJobsAreKnown) {
  SlowJournal journal;
  const std::unique_ptr<BlobStore> blobs = make_memory_blob_store();
  const FarmOptions options = {.heartbeat_interval = std::chrono::seconds(1),
                               .lease_timeout = std::chrono::seconds(8),
                               .late_results = std::chrono::minutes(1),
                               .retention = {.fetched = hours(0),
                                             .unfetched = hours(1),
                                             .max_bytes = 0,
                                             .blobs = hours(0),
                                             .interval = milliseconds(1)},
                               .seal = LeaseSeal::open({}).value()};
  const auto farm = Farm::open(journal, *blobs, options, [](const absl::Status&) {});
  ASSERT_TRUE(farm.ok()) << farm.status();
  EXPECT_FALSE(journal.committed_early());
  while (!journal.pruned()) std::this_thread::sleep_for(milliseconds{20});  // the test's own timeout is the limit
  EXPECT_TRUE((*farm)->list_jobs().jobs().empty());
}

}  // namespace
}  // namespace tessera::server
