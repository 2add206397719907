// A farm on a journal that takes its time.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>

#include "service/farm/farm.h"
#include "service/farm/farm_views.h"
#include "service/farm/job_submission.h"
#include "service/farm/worker_leases.h"
#include "service/farm/worker_registry.h"
#include "store/blobs/blob_store.h"
#include "store/journal.h"
#include "unit/server/coordinator_fixture.h"
#include "unit/server/manual_clock.h"
#include "unit/server/requests.h"
#include "unit/server/stored_blobs.h"
#include "wire/digest.h"

namespace tessera::server {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;

class EmptyJournal : public Journal {
 public:
  std::uint64_t epoch() const override { return 2; }
  absl::Status recover(const std::function<absl::Status(JobRecord)>&) override { return absl::OkStatus(); }
  absl::Status commit(const std::vector<JournalEntry>&) override { return absl::OkStatus(); }
  absl::StatusOr<JobRecord> read_job(const std::string& job) override { return absl::NotFoundError(job); }
  absl::StatusOr<std::vector<SchedulerEvent>> farm_events() override { return std::vector<SchedulerEvent>(); }
  absl::StatusOr<std::string> read_result(const std::string& job, std::uint64_t) override {
    return absl::OutOfRangeError(job);
  }
  absl::StatusOr<std::vector<CoveredUnits>> read_units(const std::string&, std::uint64_t,
                                                       std::uint32_t) override {
    return std::vector<CoveredUnits>();
  }
};

/// Has one job, cancelled long ago, and is busy with the next when the farm's clock ticks.
class SlowJournal : public EmptyJournal {
 public:
  explicit SlowJournal(ManualClock& clock) : clock_(clock) {}

  absl::Status recover(const std::function<absl::Status(JobRecord)>& visit) override {
    const v1::JobSpec spec = square_spec("a scene", 16);
    JobRecord record;
    record.added = {.id = "old", .request_id = "request", .spec = spec.SerializeAsString()};
    record.ended = {.id = "old", .state = v1::CANCELLED, .error = "", .finished_unix_ms = 1};
    absl::Status status = visit(std::move(record));
    clock_.advance(milliseconds{600});
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

  bool committed_early() const { return committed_early_; }
  bool pruned() const { return pruned_; }

 private:
  ManualClock& clock_;
  std::atomic<bool> recovered_ = false, committed_early_ = false, pruned_ = false;
};

/// Writes the choice of a class when it is told to.
class HoldingJournal : public EmptyJournal {
 public:
  absl::Status commit(const std::vector<JournalEntry>& entries) override {
    for (const JournalEntry& entry : entries) {
      if (!std::holds_alternative<JobBound>(entry)) continue;
      held_.set_value();
      released_.get_future().wait();
    }
    return absl::OkStatus();
  }

  void wait_until_held() { held_.get_future().wait(); }
  void release() { released_.set_value(); }

 private:
  std::promise<void> held_, released_;
};

FarmOptions farm_options(Retention retention) {
  return {.heartbeat_interval = std::chrono::seconds(1),
          .lease_timeout = std::chrono::seconds(8),
          .late_results = std::chrono::minutes(1),
          .retention = retention,
          .seal = seal_of_tests()};
}

TEST(FarmStart, NothingIsPrunedBeforeAllJobsAreKnown) {
  ManualClock clock;
  SlowJournal journal(clock);
  const std::unique_ptr<BlobStore> blobs = make_memory_blob_store();
  FarmOptions options = farm_options({.fetched = hours(0),
                                      .unfetched = hours(1),
                                      .max_bytes = 0,
                                      .blobs = hours(0),
                                      .interval = milliseconds(1)});
  options.clock = &clock;
  const auto farm = Farm::open(journal, *blobs, options, [](const absl::Status&) {});
  ASSERT_TRUE(farm.ok()) << farm.status();
  EXPECT_FALSE(journal.committed_early());
  while (!journal.pruned()) clock.live_through(std::chrono::seconds{1});
  EXPECT_TRUE((*farm)->views().list_jobs().jobs().empty());
}

TEST(FarmOnASlowJournal, NobodyBeginsBeforeTheChoiceOfAClassIsWritten) {
  HoldingJournal journal;
  const std::unique_ptr<BlobStore> blobs = make_memory_blob_store();
  store_blob(*blobs, kSceneBytes);
  const FarmOptions options = farm_options({.fetched = hours(1),
                                            .unfetched = hours(1),
                                            .max_bytes = std::uint64_t{1} << 40,
                                            .blobs = hours(1),
                                            .interval = hours(1)});
  const auto farm = Farm::open(journal, *blobs, options, [](const absl::Status&) {});
  ASSERT_TRUE(farm.ok()) << farm.status();
  v1::SubmitJobRequest submission;
  submission.set_request_id("request");
  *submission.mutable_spec() = square_spec(kSceneBytes, 64);
  std::promise<void> submitted;
  (*farm)->submission().submit(submission, [&](const absl::StatusOr<std::string>& id) {
    EXPECT_TRUE(id.ok()) << id.status();
    submitted.set_value();
  });
  submitted.get_future().wait();

  // The first call makes the choice; the second finds it made, and not written.
  std::promise<int> first, second;
  std::future<int> firsts_units = first.get_future(), seconds_units = second.get_future();
  const auto lease = [&](const char* name, std::promise<int>& units) {
    v1::LeaseRequest request;
    request.set_worker_id((*farm)->workers().register_worker(registration(name))->worker_id());
    request.set_max_units(1);
    (*farm)->leases().lease(
        request, {}, [] { return false; },
        [&units](const absl::StatusOr<v1::LeaseResponse>& response) {
          units.set_value(response->leases_size());
        });
  };
  lease("a", first);
  journal.wait_until_held();
  lease("b", second);
  EXPECT_EQ(firsts_units.wait_for(milliseconds{0}), std::future_status::timeout);
  EXPECT_EQ(seconds_units.wait_for(milliseconds{0}), std::future_status::timeout);
  journal.release();
  EXPECT_EQ(firsts_units.get(), 1);
  EXPECT_EQ(seconds_units.get(), 1);
}

}  // namespace
}  // namespace tessera::server
