// Results that are there already, given to new jobs.
#include "service/job/adoption.h"

#include <gmock/gmock.h>

#include "support/process/temp_dir.h"
#include "unit/server/coordinator_fixture.h"

namespace tessera::server {
namespace {

using testing::HasSubstr;

class AdoptionTest : public CoordinatorTest {
 protected:
  void SetUp() override {
    start(directory_.path());
    worker_ = register_worker("avx512");
  }

  /// Renders all that there is to do; returns how many units that was.
  int render_all() {
    const v1::LeaseResponse leases = lease(worker_, 100);
    for (const v1::Lease& lease : leases.leases()) {
      EXPECT_TRUE(complete(worker_, lease, payload_for(lease.unit())).ok());
    }
    return leases.leases_size();
  }

  grpc::Status try_submit(const v1::JobSpec& spec, const std::string& continued, bool fresh,
                          std::string* id) {
    grpc::ClientContext context;
    v1::SubmitJobRequest request;
    request.set_request_id("adoption " + std::to_string(++requests_));
    *request.mutable_spec() = spec;
    request.set_continued(continued);
    request.set_fresh(fresh);
    v1::SubmitJobResponse response;
    const grpc::Status status = farm_->SubmitJob(&context, request, &response);
    *id = response.job_id();
    return status;
  }

  /// Payloads by unit.
  std::map<std::uint32_t, std::string> results(const std::string& id) {
    v1::WatchJobRequest request;
    request.set_job_id(id);
    std::map<std::uint32_t, std::string> payloads;
    for (const v1::WatchJobResponse& message : watch(request)) {
      for (const v1::UnitResult& result : message.results()) {
        EXPECT_TRUE(payloads.emplace(result.unit().index(), result.payload()).second);
      }
    }
    return payloads;
  }

  support::TempDir directory_;
  std::string worker_;
};

TEST_F(AdoptionTest, TheSameJobIsDoneAtOnce) {
  const std::string first = submit(job_spec(2));
  ASSERT_EQ(render_all(), 8);
  const std::string second = submit(job_spec(2));
  const v1::JobStatus status = job(second);
  EXPECT_EQ(status.state(), v1::DONE);
  EXPECT_EQ(status.units_done(), 8u);
  EXPECT_EQ(status.units_adopted(), 8u);
  EXPECT_EQ(status.adopted_from(), first);
  EXPECT_EQ(status.isa(), "avx512");
  EXPECT_EQ(status.stats().samples(), 0u) << "nothing was spent";
  EXPECT_EQ(results(second), results(first));
  EXPECT_EQ(results(second).size(), 8u);
}

TEST_F(AdoptionTest, MoreSamplesAreTheRestOnly) {
  const std::string first = submit(job_spec(1));
  ASSERT_EQ(render_all(), 4);
  std::string more;
  ASSERT_TRUE(try_submit(job_spec(4), first, false, &more).ok());
  EXPECT_EQ(job(more).units_adopted(), 4u);
  EXPECT_EQ(job(more).state(), v1::RUNNING);
  EXPECT_EQ(render_all(), 12);
  EXPECT_EQ(job(more).state(), v1::DONE);
  EXPECT_EQ(job(more).stats().samples(), 1200u);
  EXPECT_EQ(results(more).size(), 16u);
}

TEST_F(AdoptionTest, ARangeThatWasCutIsRenderedAnew) {
  v1::JobSpec ragged = job_spec(2);
  ragged.mutable_samples()->set_spp(6);
  submit(ragged);
  ASSERT_EQ(render_all(), 8);
  EXPECT_EQ(job(submit(job_spec(2))).units_adopted(), 4u);
  EXPECT_EQ(render_all(), 4);
}

TEST_F(AdoptionTest, ARunningJobGivesWhatItHas) {
  const std::string first = submit(job_spec(2));
  const v1::LeaseResponse leases = lease(worker_, 3);
  ASSERT_TRUE(complete(worker_, leases.leases(0), payload_for(leases.leases(0).unit())).ok());
  EXPECT_EQ(job(submit(job_spec(2))).units_adopted(), 1u);
}

TEST_F(AdoptionTest, FreshOnesAndOtherContentAreRendered) {
  const std::string first = submit(job_spec(1));
  ASSERT_EQ(render_all(), 4);
  std::string id;
  ASSERT_TRUE(try_submit(job_spec(1), "", /*fresh=*/true, &id).ok());
  EXPECT_EQ(job(id).units_adopted(), 0u);
  EXPECT_EQ(render_all(), 4);
  v1::JobSpec other = job_spec(1);
  other.mutable_view()->set_seed(7);
  EXPECT_EQ(job(submit(other)).units_adopted(), 0u);
  EXPECT_EQ(render_all(), 4);
  other = job_spec(1);
  other.mutable_farm()->set_isa("avx2");
  EXPECT_EQ(job(submit(other)).units_adopted(), 0u) << "the results are of another ISA";
}

TEST_F(AdoptionTest, WhatCannotBeContinuedIsRefusedByName) {
  const std::string first = submit(job_spec(1));
  ASSERT_EQ(render_all(), 4);
  std::string id;
  v1::JobSpec other = job_spec(2);
  other.mutable_view()->set_seed(7);
  grpc::Status status = try_submit(other, first, false, &id);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(status.error_message(), HasSubstr("view.seed: 7"));
  other = job_spec(2);
  other.mutable_farm()->set_isa("avx2");
  status = try_submit(other, first, false, &id);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(status.error_message(), HasSubstr("isa: \"avx512\" -> \"avx2\""));
  EXPECT_EQ(try_submit(job_spec(2), "nothing", false, &id).error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(AdoptionTest, WhatWasTakenOverSurvivesARestart) {
  const std::string first = submit(job_spec(1));
  ASSERT_EQ(render_all(), 4);
  std::string more;
  ASSERT_TRUE(try_submit(job_spec(2), first, false, &more).ok());
  const std::string same = submit(job_spec(1));
  start(directory_.path());
  EXPECT_EQ(job(same).state(), v1::DONE);
  EXPECT_EQ(job(same).adopted_from(), first);
  EXPECT_EQ(job(same).stats().samples(), 0u);
  EXPECT_EQ(results(same), results(first));
  EXPECT_EQ(job(more).units_adopted(), 4u);
  EXPECT_EQ(job(more).isa(), "avx512");
  worker_ = register_worker("avx512");
  EXPECT_EQ(render_all(), 4);
  EXPECT_EQ(results(more).size(), 8u);
  // A job of before the restart is a donor like any other.
  EXPECT_EQ(job(submit(job_spec(2))).units_adopted(), 8u);
}

TEST(Content, IsWhatResultsDependOn) {
  v1::JobSpec a, b;
  a.mutable_farm()->set_name("a"), b.mutable_farm()->set_name("b");
  a.mutable_farm()->set_user("a"), b.mutable_farm()->set_priority(3);
  a.mutable_farm()->set_max_workers(1), b.mutable_farm()->add_required_tags("big");
  a.mutable_samples()->set_spp(4), b.mutable_samples()->set_spp(8);
  a.mutable_content()->set_scene("s"), b.mutable_content()->set_scene("s");
  a.mutable_farm()->add_blobs()->set_size_bytes(7);
  EXPECT_EQ(difference_in_content(a, b), "");
  EXPECT_EQ(result_key(a), result_key(b));
  a.mutable_samples()->set_noise(0.1), b.mutable_samples()->set_noise(0.1);
  EXPECT_THAT(difference_in_content(a, b), HasSubstr("samples.spp")) << "the cap is part of the decision";
  EXPECT_NE(result_key(a), result_key(b));
  b.mutable_samples()->set_spp(4);
  EXPECT_EQ(difference_in_content(a, b), "");
  EXPECT_EQ(result_key(a), result_key(b));
  b.mutable_content()->set_build("0.0.1");
  EXPECT_NE(result_key(a), result_key(b));
  EXPECT_THAT(difference_in_content(a, b), HasSubstr("build"));
}

}  // namespace
}  // namespace tessera::server
