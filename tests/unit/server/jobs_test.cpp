// FarmService.
#include <gmock/gmock.h>

#include <chrono>
#include <future>
#include <set>
#include <thread>

#include "support/process/peak_memory.h"
#include "unit/server/coordinator_fixture.h"
#include "wire/limits.h"

namespace tessera::server {
namespace {

class JobsTest : public CoordinatorTest {
 protected:
  void SetUp() override { start(); }

  grpc::Status try_submit(const std::string& request_id, const v1::JobSpec& spec, std::string* id = nullptr) {
    grpc::ClientContext context;
    v1::SubmitJobRequest request;
    request.set_request_id(request_id);
    *request.mutable_spec() = spec;
    v1::SubmitJobResponse response;
    const grpc::Status status = farm_->SubmitJob(&context, request, &response);
    if (id != nullptr) *id = response.job_id();
    return status;
  }

  grpc::Status cancel(const std::string& id) {
    grpc::ClientContext context;
    v1::CancelJobRequest request;
    request.set_job_id(id);
    v1::CancelJobResponse response;
    return farm_->CancelJob(&context, request, &response);
  }

  grpc::Status delete_job(const std::string& id) {
    grpc::ClientContext context;
    v1::DeleteJobRequest request;
    request.set_job_id(id);
    v1::DeleteJobResponse response;
    return farm_->DeleteJob(&context, request, &response);
  }

  void render_all(const std::string& worker) {
    const v1::LeaseResponse leases = lease(worker, 100);
    for (const v1::Lease& lease : leases.leases()) {
      ASSERT_TRUE(complete(worker, lease, payload_for(lease.unit())).ok());
    }
  }

  /// Whether the only worker made a call after `then`; right when true, and after a while when it did.
  /// Whether the only worker was heard of since the clock was moved.
  bool worker_is_seen() {
    grpc::ClientContext context;
    v1::ListWorkersResponse response;
    EXPECT_TRUE(farm_->ListWorkers(&context, {}, &response).ok());
    return response.workers_size() == 1 && response.workers(0).last_seen_ms_ago() == 0;
  }

  static v1::WatchJobRequest watch_request(const std::string& id, std::uint64_t after = 0) {
    v1::WatchJobRequest request;
    request.set_job_id(id);
    request.set_after(after);
    return request;
  }
};

TEST_F(JobsTest, AJobFromSubmissionToTheLastResult) {
  const std::string id = submit(job_spec(2));
  EXPECT_EQ(job(id).state(), v1::QUEUED);
  EXPECT_EQ(job(id).units_total(), 8u);
  EXPECT_EQ(job(id).uploaded_bytes(), std::string("a scene").size());
  auto watched = std::async([&] { return watch(watch_request(id)); });
  const std::string worker = register_worker();
  render_all(worker);

  const std::vector<v1::WatchJobResponse> messages = watched.get();
  std::uint64_t sequence = 0;
  std::set<std::uint32_t> units;
  for (const v1::WatchJobResponse& message : messages) {
    for (const v1::UnitResult& result : message.results()) {
      EXPECT_EQ(result.sequence(), ++sequence);
      units.insert(result.unit().index());
      EXPECT_EQ(result.payload(), payload_for(result.unit()));
    }
  }
  EXPECT_EQ(units.size(), 8u);
  const v1::JobStatus last = messages.back().status();
  EXPECT_EQ(last.state(), v1::DONE);
  EXPECT_EQ(last.units_done(), 8u);
  EXPECT_EQ(last.isa(), "avx2");
  EXPECT_EQ(last.stats().samples(), 800u);
  EXPECT_EQ(last.stats().cpu_time().seconds(), 0);
  EXPECT_EQ(last.stats().cpu_time().nanos(), 5'600'000);  // 8 * 0.7 ms
  EXPECT_GE(last.finished_unix_ms(), last.submitted_unix_ms());
}

TEST_F(JobsTest, AWatcherComesLateOrComesBack) {
  const std::string id = submit(job_spec());
  render_all(register_worker());
  EXPECT_EQ(watch(watch_request(id)).back().results_size(), 4);
  const auto rest = watch(watch_request(id, 3));
  ASSERT_EQ(rest.back().results_size(), 1);
  EXPECT_EQ(rest.back().results(0).sequence(), 4u);
  EXPECT_EQ(watch(watch_request(id, 4)).back().results_size(), 0);
  v1::WatchJobRequest status_only = watch_request(id);
  status_only.set_status_only(true);
  EXPECT_EQ(watch(status_only).back().results_size(), 0);
  watch(watch_request("nothing"), grpc::StatusCode::NOT_FOUND);
}

TEST_F(JobsTest, AJobThatIsOverTakesNoMemoryAndIsFetchedFromTheJournal) {
  CoordinatorOptions options;
  options.late_results = std::chrono::milliseconds(0);
  options.clock = &clock_;
  start(std::move(options));
  const std::string id = submit(job_spec());
  const std::string worker = register_worker();
  const v1::LeaseResponse leases = lease(worker, 100);
  for (const v1::Lease& lease : leases.leases())
    ASSERT_TRUE(complete(worker, lease, payload_for(lease.unit())).ok());
  const v1::JobStatus before = job(id);
  // A late result is compared with the accepted one as long as its fingerprint is kept.
  while (!complete(worker, leases.leases(0), payload_for(leases.leases(0).unit(), /*seed=*/1)).ok()) {
    clock_.live_through(std::chrono::seconds{1});
  }
  EXPECT_EQ(job(id).DebugString(), before.DebugString());
  std::set<std::uint32_t> units;
  std::uint64_t sequence = 0;
  for (const v1::WatchJobResponse& message : watch(watch_request(id))) {
    for (const v1::UnitResult& result : message.results()) {
      EXPECT_EQ(result.sequence(), ++sequence);
      EXPECT_EQ(result.payload(), payload_for(result.unit()));
      EXPECT_TRUE(units.insert(result.unit().index()).second);
    }
  }
  EXPECT_EQ(units.size(), 4u);
  EXPECT_TRUE(cancel(id).ok());
  EXPECT_EQ(job(id).state(), v1::DONE);
}

TEST_F(JobsTest, CancellingEndsTheStream) {
  const std::string id = submit(job_spec());
  auto watched = std::async([&] { return watch(watch_request(id)); });
  EXPECT_TRUE(cancel(id).ok());
  EXPECT_EQ(watched.get().back().status().state(), v1::CANCELLED);
  EXPECT_TRUE(cancel(id).ok());
  EXPECT_EQ(cancel("nothing").error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(JobsTest, AJobThatIsOverIsDeletedOnRequest) {
  const std::string id = submit(job_spec());
  EXPECT_EQ(delete_job(id).error_code(), grpc::StatusCode::FAILED_PRECONDITION) << "it runs";
  render_all(register_worker());
  EXPECT_EQ(job(id).state(), v1::DONE);
  EXPECT_TRUE(delete_job(id).ok());
  EXPECT_EQ(delete_job(id).error_code(), grpc::StatusCode::NOT_FOUND);
  grpc::ClientContext context;
  v1::ListJobsResponse jobs;
  ASSERT_TRUE(farm_->ListJobs(&context, {}, &jobs).ok());
  EXPECT_EQ(jobs.jobs_size(), 0);
}

TEST_F(JobsTest, WhoWorksOnWhatIsSaidOnBothSides) {
  v1::JobSpec spec = job_spec();
  spec.mutable_farm()->set_name("box");
  spec.mutable_farm()->set_user("alice");
  const std::string id = submit(spec);
  const std::string worker = register_worker();
  EXPECT_EQ(job(id).workers(), 0u);
  ASSERT_EQ(lease(worker, 2).leases_size(), 2);
  const v1::GetJobResponse response = get_job(id);
  EXPECT_EQ(response.status().workers(), 1u);
  ASSERT_EQ(response.workers_size(), 1);
  EXPECT_EQ(response.workers(0).leases(), 2u);
  grpc::ClientContext context;
  v1::ListWorkersResponse workers;
  ASSERT_TRUE(farm_->ListWorkers(&context, {}, &workers).ok());
  ASSERT_EQ(workers.workers(0).jobs_size(), 1);
  const v1::WorkerJob& job = workers.workers(0).jobs(0);
  EXPECT_EQ(job.job_id(), id);
  EXPECT_EQ(job.name(), "box");
  EXPECT_EQ(job.user(), "alice");
  EXPECT_EQ(job.leases(), 2u);
  EXPECT_EQ(workers.workers(0).name(), response.workers(0).name());
}

TEST_F(JobsTest, AUnitThatFailsIsToldAtOnce) {
  const std::string id = submit(job_spec());
  const std::string worker = register_worker();
  const v1::LeaseResponse leases = lease(worker, 1);
  ASSERT_EQ(leases.leases_size(), 1);
  EXPECT_EQ(job(id).failures(), 0u);
  ASSERT_TRUE(fail(worker, leases.leases(0), "the texture is gone").ok());
  const v1::JobStatus status = job(id);
  EXPECT_EQ(status.units_set_aside(), 0u) << "it is tried again";
  EXPECT_EQ(status.failures(), 1u);
  ASSERT_EQ(status.latest_failures_size(), 1);
  EXPECT_EQ(status.latest_failures(0).unit_index(), leases.leases(0).unit().index());
  EXPECT_EQ(status.latest_failures(0).failure().message(), "the texture is gone");
}

TEST_F(JobsTest, FailuresHaveTheWorkersLastLines) {
  const std::string id = submit(job_spec());
  const std::string worker = register_worker();
  std::vector<std::string> long_log(100, std::string(100, 'x'));
  long_log.push_back("the texture is gone");
  for (int attempt = 0; attempt < 100 && job(id).units_set_aside() == 0; ++attempt) {
    const v1::LeaseResponse granted = lease(worker, 1);
    for (const v1::Lease& one : granted.leases()) ASSERT_TRUE(fail(worker, one, "no texture", long_log).ok());
  }
  const v1::JobStatus status = job(id);
  ASSERT_GT(status.set_aside_size(), 0);
  for (const v1::UnitFailure& failure : status.set_aside(0).failures()) {
    ASSERT_EQ(failure.log_size(), 41) << "4096 bytes of them";
    EXPECT_EQ(failure.log(40), "the texture is gone");
  }
  const int latest = status.latest_failures_size();
  ASSERT_GT(latest, 0);
  EXPECT_EQ(status.latest_failures(latest - 1).failure().log_size(), 41);
  ASSERT_TRUE(cancel(id).ok());
  const v1::JobStatus watched = watch(watch_request(id)).back().status();
  ASSERT_GT(watched.latest_failures_size(), 0);
  EXPECT_EQ(watched.latest_failures(0).failure().log_size(), 0) << "who watches hears of them often";
}

TEST_F(JobsTest, AFailedJobSaysWhy) {
  const std::string id = submit(job_spec());
  const std::string worker = register_worker();
  v1::FailRequest request;
  request.set_worker_id(worker);
  *request.mutable_token() = lease(worker, 1).leases(0).token();
  request.set_message("mesh 3: index out of range");
  request.set_scene_fault(true);
  request.add_log("the last line");
  grpc::ClientContext context;
  v1::FailResponse response;
  ASSERT_TRUE(work_->Fail(&context, request, &response).ok());
  const auto last = watch(watch_request(id)).back().status();
  EXPECT_EQ(last.state(), v1::FAILED);
  EXPECT_EQ(last.error(), "mesh 3: index out of range");
  const v1::JobStatus status = job(id);
  ASSERT_EQ(status.latest_failures_size(), 1);
  EXPECT_THAT(status.latest_failures(0).failure().log(), testing::ElementsAre("the last line"));
}

TEST_F(JobsTest, SubmittingTwiceIsOneJob) {
  const v1::JobSpec spec = job_spec();
  std::string first, second, other;
  ASSERT_TRUE(try_submit("x", spec, &first).ok());
  ASSERT_TRUE(try_submit("x", spec, &second).ok());
  ASSERT_TRUE(try_submit("y", spec, &other).ok());
  EXPECT_EQ(first, second);
  EXPECT_NE(first, other);
  grpc::ClientContext context;
  v1::ListJobsResponse jobs;
  ASSERT_TRUE(farm_->ListJobs(&context, {}, &jobs).ok());
  ASSERT_EQ(jobs.jobs_size(), 2);
  EXPECT_EQ(jobs.jobs(0).job_id(), first);
}

TEST_F(JobsTest, UnsoundJobsAreRefused) {
  v1::JobSpec spec = job_spec();
  EXPECT_EQ(try_submit("", spec).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  spec.mutable_farm()->add_blobs()->set_digest(std::string(64, 'e'));
  spec.mutable_farm()->mutable_blobs(1)->set_path("kitchen.ply");
  const grpc::Status missing = try_submit("a", spec);
  EXPECT_EQ(missing.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(missing.error_message(), testing::HasSubstr("kitchen.ply"));
  spec.mutable_farm()->mutable_blobs()->RemoveLast();
  spec.mutable_cut()->set_tile_size(0);
  EXPECT_EQ(try_submit("a", spec).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(JobsTest, HaveSoManyUnitsTogetherAndNoMore) {
  CoordinatorOptions options;
  options.max_open_units = 8;
  options.late_results = std::chrono::milliseconds{0};
  options.clock = &clock_;
  start(options);
  const v1::JobSpec spec = job_spec();  // four units
  std::string first, second, again;
  ASSERT_TRUE(try_submit("first", spec, &first).ok());
  ASSERT_TRUE(try_submit("second", spec, &second).ok());
  const grpc::Status refused = try_submit("third", spec);
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(refused.error_message(), testing::HasSubstr("12 units"));
  EXPECT_TRUE(try_submit("second", spec, &again).ok()) << "it is there";
  EXPECT_EQ(again, second);
  // Once a job is over, there is room: at the next tick, when its units are forgotten.
  ASSERT_TRUE(cancel(first).ok());
  while (try_submit("third", spec).error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED) {
    clock_.live_through(std::chrono::seconds{1});
  }
  EXPECT_EQ(try_submit("fourth", spec).error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
}

TEST_F(JobsTest, AJobOfSixteenMillionUnitsTakesTheMemoryOfThoseThatWereBegun) {
  constexpr std::uint32_t kSide = 1 << 16;
  v1::JobSpec spec = job_spec();
  for (const auto set : {&v1::PixelRect::set_x1, &v1::PixelRect::set_y1})
    (spec.mutable_cut()->mutable_crop()->*set)(kSide);
  spec.mutable_view()->set_width(kSide);
  spec.mutable_view()->set_height(kSide);
  const std::string worker = register_worker();
  const support::PeakMemory memory;
  std::string id;
  ASSERT_TRUE(try_submit("large", spec, &id).ok());
  EXPECT_EQ(job(id).units_total(), wire::kMaxUnitsPerJob);
  render_all(worker);
  EXPECT_EQ(job(id).units_done(), 100u);
  // One byte a unit would be 16 MiB; calls and results of this test take less than 8.
  if (const auto growth = memory.growth()) {
    EXPECT_LT(*growth, std::uint64_t{12} << 20);
  }
}

TEST_F(JobsTest, ShutdownEndsEveryCall) {
  CoordinatorOptions options;
  options.clock = &clock_;
  start(std::move(options));
  const std::string id = submit(job_spec());
  grpc::ClientContext watch_context;
  const auto watched = farm_->WatchJob(&watch_context, watch_request(id));
  v1::WatchJobResponse message;
  ASSERT_TRUE(watched->Read(&message));  // the call is under way then
  v1::LeaseRequest request;
  request.set_worker_id(register_worker("avx512"));
  // Takes the four units, so that the next call waits.
  EXPECT_EQ(lease(request.worker_id(), 4).leases_size(), 4);
  request.set_max_units(1);
  request.mutable_max_wait()->set_seconds(20);
  clock_.live_through(std::chrono::seconds{1});
  auto leased = std::async(std::launch::async, [&] {
    grpc::ClientContext context;
    v1::LeaseResponse response;
    return work_->Lease(&context, request, &response).error_code();
  });
  // gRPC ends a call that arrives during the shutdown with Cancelled: this is about calls that came before.
  while (!worker_is_seen()) std::this_thread::yield();
  coordinator_->request_shutdown();
  EXPECT_TRUE(coordinator_->wait().ok());
  EXPECT_EQ(leased.get(), grpc::StatusCode::UNAVAILABLE);
  while (watched->Read(&message)) continue;
  EXPECT_EQ(watched->Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
}

TEST_F(JobsTest, CallsAfterTheShutdownFail) {
  coordinator_->request_shutdown();
  EXPECT_TRUE(coordinator_->wait().ok());
  EXPECT_EQ(try_submit("late", {}).error_code(), grpc::StatusCode::UNAVAILABLE);
  stop();
  EXPECT_EQ(try_submit("later", {}).error_code(), grpc::StatusCode::UNAVAILABLE);
}

}  // namespace
}  // namespace tessera::server
