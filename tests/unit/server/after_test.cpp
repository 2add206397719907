// Jobs that come after others (JobSpec.Farm.after), and who is told of their ends.
#include <gmock/gmock.h>

#include <mutex>

#include "service/job/end_listener.h"
#include "support/process/temp_dir.h"
#include "unit/server/coordinator_fixture.h"

namespace tessera::server {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

class AfterTest : public CoordinatorTest {
 protected:
  /// A job that shares no result with others.
  v1::JobSpec spec_after(const std::vector<std::string>& jobs) {
    v1::JobSpec spec = job_spec();
    spec.mutable_view()->set_seed(++seeds_);
    for (const std::string& id : jobs) spec.mutable_farm()->add_after(id);
    return spec;
  }
  grpc::Status try_submit(const v1::JobSpec& spec) {
    v1::SubmitJobRequest request;
    request.set_request_id("refused");
    *request.mutable_spec() = spec;
    v1::SubmitJobResponse response;
    grpc::ClientContext context;
    return farm_->SubmitJob(&context, request, &response);
  }
  v1::JobStatus cancel(const std::string& id) {
    v1::CancelJobRequest request;
    request.set_job_id(id);
    v1::CancelJobResponse response;
    grpc::ClientContext context;
    EXPECT_TRUE(farm_->CancelJob(&context, request, &response).ok());
    return response.status();
  }
  grpc::Status erase(const std::string& id) {
    v1::DeleteJobRequest request;
    request.set_job_id(id);
    v1::DeleteJobResponse response;
    grpc::ClientContext context;
    return farm_->DeleteJob(&context, request, &response);
  }
  /// Does what is to be had now; how many units that were.
  int work(const std::string& worker) {
    const v1::LeaseResponse leases = lease(worker, 100);
    for (const v1::Lease& lease : leases.leases())
      EXPECT_TRUE(complete(worker, lease, payload_for(lease.unit())).ok());
    return leases.leases_size();
  }

  std::uint64_t seeds_ = 100;
  support::TempDir directory_;
};

TEST_F(AfterTest, AJobWaitsUntilAllOthersAreDone) {
  start();
  const std::string first = submit(spec_after({})), second = submit(spec_after({}));
  const std::string last = submit(spec_after({first, second}));
  EXPECT_THAT(job(last).after(), UnorderedElementsAre(first, second));
  EXPECT_THAT(job(last).waiting_for(), testing::AnyOf(HasSubstr("there is no worker"), HasSubstr("first")));
  const std::string worker = register_worker();
  v1::LeaseResponse leases = lease(worker, 100);
  ASSERT_EQ(leases.leases_size(), 8) << "the units of the first two";
  for (const v1::Lease& one : leases.leases()) EXPECT_NE(one.token().job_id(), last);
  EXPECT_THAT(job(last).waiting_for(), HasSubstr("has to be done first"));
  for (const v1::Lease& one : leases.leases())
    ASSERT_TRUE(complete(worker, one, payload_for(one.unit())).ok());
  EXPECT_THAT(job(last).after(), IsEmpty());
  EXPECT_EQ(work(worker), 4);
  EXPECT_EQ(job(last).state(), v1::DONE);
}

TEST_F(AfterTest, WhatIsAwaitedInVainFailsAndNamesIt) {
  start();
  const std::string first = submit(spec_after({})), second = submit(spec_after({first}));
  const std::string third = submit(spec_after({second})), other = submit(spec_after({}));
  cancel(first);
  EXPECT_EQ(job(second).state(), v1::FAILED);
  EXPECT_THAT(job(second).error(), HasSubstr("job " + first));
  EXPECT_THAT(job(second).error(), HasSubstr("was cancelled"));
  EXPECT_EQ(job(third).state(), v1::FAILED);
  EXPECT_THAT(job(third).error(), HasSubstr("job " + second));
  EXPECT_EQ(job(other).state(), v1::QUEUED);
  const grpc::Status late = try_submit(spec_after({first}));
  EXPECT_EQ(late.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(late.error_message(), HasSubstr("was cancelled"));
}

TEST_F(AfterTest, OnlyJobsThatAreThereCanBeAwaited) {
  start();
  EXPECT_EQ(try_submit(spec_after({"0123abcd"})).error_code(), grpc::StatusCode::NOT_FOUND);
  const std::string first = submit(spec_after({}));
  const std::vector<std::string> many(65, first);
  EXPECT_EQ(try_submit(spec_after(many)).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(AfterTest, AChainOfThousandsFailsAtOnce) {
  start();
  std::string last = submit(spec_after({}));
  const std::string first = last;
  for (int i = 0; i < 2000; ++i) last = submit(spec_after({last}));
  cancel(first);
  EXPECT_EQ(job(last).state(), v1::FAILED);
}

TEST_F(AfterTest, ACoordinatorThatStartsAgainRemembers) {
  start(directory_.path());
  const std::string done = submit(spec_after({}));
  std::string worker = register_worker();
  EXPECT_EQ(work(worker), 4);
  const std::string open = submit(spec_after({}));
  const std::string free = submit(spec_after({done})), held = submit(spec_after({done, open}));
  const std::string doomed = submit(spec_after({}));
  const std::string failed = submit(spec_after({doomed}));
  cancel(doomed);

  start(directory_.path());
  EXPECT_THAT(job(free).after(), IsEmpty());
  EXPECT_THAT(job(held).after(), ElementsAre(open));
  EXPECT_EQ(job(failed).state(), v1::FAILED);
  worker = register_worker();
  EXPECT_EQ(work(worker), 8) << "of the open job, and of the one that is free";
  EXPECT_EQ(job(open).state(), v1::DONE);
  EXPECT_EQ(work(worker), 4) << "of the one that was held";
  EXPECT_EQ(job(held).state(), v1::DONE);
}

TEST_F(AfterTest, AJobThatIsDoneMayBeForgotten) {
  start(directory_.path());
  const std::string first = submit(spec_after({}));
  std::string worker = register_worker();
  EXPECT_EQ(work(worker), 4);
  const std::string second = submit(spec_after({first}));
  ASSERT_TRUE(erase(first).ok());
  start(directory_.path());
  EXPECT_EQ(work(register_worker()), 4);
  EXPECT_EQ(job(second).state(), v1::DONE);
}

/// Remembers what it is told.
class EndRecorder final : public EndListener {
 public:
  absl::Status check_webhook(const std::string& url) const override {
    return url == "https://good/" ? absl::OkStatus() : absl::PermissionDeniedError("not there");
  }
  void ended(const v1::JobStatus& status, const std::string& webhook) override {
    const std::lock_guard lock(mutex_);
    told_.push_back(status.job_id() + " " + v1::JobState_Name(status.state()) + " " + webhook);
  }
  std::vector<std::string> told() const {
    const std::lock_guard lock(mutex_);
    return told_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> told_;
};

TEST_F(AfterTest, AListenerIsToldOfEveryEndOnce) {
  EndRecorder listener;
  start(CoordinatorOptions{.listen = "127.0.0.1:0", .data_dir = directory_.path(), .listener = &listener});
  v1::JobSpec spec = spec_after({});
  spec.mutable_farm()->set_webhook("https://good/");
  const std::string first = submit(spec), second = submit(spec_after({}));
  const std::string third = submit(spec_after({second}));
  spec.mutable_farm()->set_webhook("https://bad/");
  EXPECT_EQ(try_submit(spec).error_code(), grpc::StatusCode::PERMISSION_DENIED);
  cancel(second);
  EXPECT_EQ(work(register_worker()), 4);
  EXPECT_EQ(job(first).state(), v1::DONE);
  const std::vector<std::string> all = {second + " CANCELLED ", third + " FAILED ",
                                        first + " DONE https://good/"};
  EXPECT_THAT(listener.told(), testing::UnorderedElementsAreArray(all));
  // Jobs that had ended before are no news to the next coordinator.
  start(CoordinatorOptions{.listen = "127.0.0.1:0", .data_dir = directory_.path(), .listener = &listener});
  EXPECT_EQ(job(first).state(), v1::DONE);
  EXPECT_THAT(listener.told(), testing::UnorderedElementsAreArray(all));
  stop();
}

TEST_F(AfterTest, WithoutAListenerThereAreNoWebhooks) {
  start();
  v1::JobSpec spec = spec_after({});
  spec.mutable_farm()->set_webhook("https://good/");
  EXPECT_EQ(try_submit(spec).error_code(), grpc::StatusCode::PERMISSION_DENIED);
}

}  // namespace
}  // namespace tessera::server
