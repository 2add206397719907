// A farm called by many threads at once, without gRPC in between: what the thread sanitizer says of it is
// about the farm alone.
#include <google/protobuf/util/time_util.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <latch>
#include <set>
#include <thread>

#include "service/farm/farm.h"
#include "service/farm/farm_views.h"
#include "service/farm/job_control.h"
#include "service/farm/job_submission.h"
#include "service/farm/unit_results.h"
#include "service/farm/user_shares.h"
#include "service/farm/worker_leases.h"
#include "service/farm/worker_registry.h"
#include "store/blobs/blob_store.h"
#include "store/journal.h"
#include "unit/server/coordinator_fixture.h"
#include "unit/server/requests.h"
#include "unit/server/stored_blobs.h"
#include "wire/digest.h"

namespace tessera::server {
namespace {

using google::protobuf::util::TimeUtil;
using std::chrono::hours;
using std::chrono::milliseconds;

constexpr std::uint32_t kJobUnits = 16;

/// Waits for the answer of a call that gives it through a `done`.
template <typename T, typename Call>
T answer_of(const Call& call) {
  auto promise = std::make_shared<std::promise<T>>();
  std::future<T> future = promise->get_future();
  call([promise](const T& answer) { promise->set_value(answer); });
  return future.get();
}

class FarmThreads : public testing::Test {
 protected:
  FarmThreads() : journal_(*open_journal({})), blobs_(make_memory_blob_store()) {
    store_blob(*blobs_, kSceneBytes);
    auto farm = Farm::open(*journal_, *blobs_,
                           {.heartbeat_interval = milliseconds(50),
                            .lease_timeout = std::chrono::seconds(60),
                            .late_results = milliseconds(0),
                            .retention = {.fetched = hours(1),
                                          .unfetched = hours(1),
                                          .max_bytes = std::uint64_t{1} << 40,
                                          .blobs = hours(1),
                                          .interval = milliseconds(1)},
                            .seal = seal_of_tests()},
                           [](const absl::Status& why) { ADD_FAILURE() << why; });
    EXPECT_TRUE(farm.ok()) << farm.status();
    farm_ = *std::move(farm);
  }

  absl::StatusOr<std::string> submit(int seed) {
    v1::SubmitJobRequest request;
    request.set_request_id("request " + std::to_string(seed));
    *request.mutable_spec() = square_spec(kSceneBytes, 64);
    request.mutable_spec()->mutable_view()->set_seed(static_cast<std::uint64_t>(seed));
    return answer_of<absl::StatusOr<std::string>>(
        [&](auto done) { farm_->submission().submit(request, done); });
  }

  /// Until the job is over: its results, each once.
  void watch(const std::string& id) {
    std::set<std::uint32_t> units;
    for (std::uint64_t after = 0; true; std::this_thread::yield()) {
      const absl::StatusOr<WatchBatch> batch = farm_->views().next_results(id, after, /*status_only=*/false);
      ASSERT_TRUE(batch.ok()) << batch.status();
      after = batch->last;
      for (const v1::UnitResult& result : batch->response.results()) {
        EXPECT_TRUE(units.insert(result.unit().index()).second);
      }
      if (!batch->finished) continue;
      EXPECT_TRUE(units.size() == kJobUnits || batch->response.status().state() == v1::CANCELLED)
          << units.size();
      farm_->jobs().note_fetched(id);
      return;
    }
  }

  void work(const std::string& name, std::stop_token stop) {
    const auto worker = farm_->workers().register_worker(registration(name));
    ASSERT_TRUE(worker.ok()) << worker.status();
    v1::LeaseRequest request;
    request.set_worker_id(worker->worker_id());
    request.set_max_units(3);
    *request.mutable_max_wait() = TimeUtil::MillisecondsToDuration(100);
    while (!stop.stop_requested()) {
      const auto response = answer_of<absl::StatusOr<v1::LeaseResponse>>([&](auto done) {
        farm_->leases().lease(
            request, {}, [] { return false; }, done);
      });
      if (absl::IsUnavailable(response.status())) return;  // the farm is stopping
      ASSERT_TRUE(response.ok()) << response.status();
      v1::HeartbeatRequest beat;
      beat.set_worker_id(worker->worker_id());
      for (const v1::Lease& lease : response->leases()) *beat.add_leases() = lease.token();
      static_cast<void>(farm_->leases().heartbeat(beat));
      for (const v1::Lease& lease : response->leases()) complete(worker->worker_id(), lease);
    }
    static_cast<void>(farm_->workers().deregister(worker->worker_id()));
  }

  /// The answer of a job that was cancelled meanwhile does not matter.
  void complete(const std::string& worker, const v1::Lease& lease) {
    v1::CompleteRequest request;
    request.set_worker_id(worker);
    *request.mutable_token() = lease.token();
    request.set_payload(payload_for(lease.unit()));
    *request.mutable_stats()->mutable_wall_time() = TimeUtil::MillisecondsToDuration(3);
    static_cast<void>(answer_of<absl::StatusOr<v1::CompleteResponse>>(
        [&](auto done) { farm_->results().complete(request, {}, done); }));
  }

  std::unique_ptr<Journal> journal_;
  std::unique_ptr<BlobStore> blobs_;
  std::unique_ptr<Farm> farm_;
};

TEST_F(FarmThreads, ClientsAndWorkersAllAtOnce) {
  std::vector<std::jthread> workers, clients;
  for (const char* name : {"a", "b", "c"}) {
    workers.emplace_back([this, name](std::stop_token stop) { work(name, stop); });
  }
  workers.emplace_back([this](std::stop_token stop) {  // somebody who looks on
    while (!stop.stop_requested()) {
      const v1::ListJobsResponse jobs = farm_->views().list_jobs();
      for (const v1::JobStatus& job : jobs.jobs()) static_cast<void>(farm_->views().get_job(job.job_id()));
      static_cast<void>(farm_->views().list_workers());
      farm_->shares().note_upload(wire::sha256_hex(kSceneBytes), 1);
      std::this_thread::yield();
    }
  });
  for (int client = 0; client < 3; ++client) {
    clients.emplace_back([this, client] {
      for (int i = 0; i < 6; ++i) {
        const auto id = submit(10 * client + i);
        ASSERT_TRUE(id.ok()) << id.status();
        if (client == 2 && i % 2 == 1) {
          static_cast<void>(
              answer_of<absl::StatusOr<v1::JobStatus>>([&](auto done) { farm_->jobs().cancel(*id, done); }));
        }
        watch(*id);
      }
    });
  }
  clients.clear();  // joins
  workers.clear();
  const v1::ListJobsResponse jobs = farm_->views().list_jobs();
  for (const v1::JobStatus& job : jobs.jobs()) {
    EXPECT_TRUE(job.state() == v1::DONE || job.state() == v1::CANCELLED) << job.job_id();
  }
}

TEST_F(FarmThreads, EveryCallIsAnsweredWhenTheFarmStops) {
  std::vector<std::jthread> callers;
  for (const char* name : {"a", "b"}) {
    callers.emplace_back([this, name](std::stop_token stop) { work(name, stop); });
  }
  std::latch woken{3}, submitted{20};
  farm_->subscribe([&woken] {
    if (woken.try_wait()) return true;
    woken.count_down();
    return true;
  });
  callers.emplace_back([&] {
    for (int seed = 0; submit(seed).ok(); ++seed) {
      if (!submitted.try_wait()) submitted.count_down();
    }
  });
  woken.wait();
  submitted.wait();
  farm_->stop();
  callers.clear();  // joins: each got its answer
  EXPECT_TRUE(absl::IsUnavailable(submit(1000).status()));
}

}  // namespace
}  // namespace tessera::server
