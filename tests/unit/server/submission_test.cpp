// A submission that comes to nothing leaves nothing behind.
#include "service/farm/job_submission.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>

#include "service/farm/farm_core.h"
#include "service/farm/user_shares.h"
#include "service/job/adoption.h"
#include "unit/server/coordinator_fixture.h"
#include "unit/server/requests.h"
#include "unit/server/stored_blobs.h"

namespace tessera::server {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

/// The parts that take jobs, whose names are those of `names_`, in turn.
class SubmissionTest : public testing::Test {
 protected:
  SubmissionTest() {
    store_blob(*blobs_, kSceneBytes);
    EXPECT_TRUE(core_.recover().ok());
    core_.start([] {});
  }
  ~SubmissionTest() override {
    core_.stop();
    core_.close();
  }

  FarmOptions options() {
    FarmOptions options;
    options.seal = seal_of_tests();
    options.make_identifier = [this](int) { return names_.at(made_++); };
    return options;
  }

  absl::StatusOr<std::string> submit() {
    v1::SubmitJobRequest request;
    request.set_request_id("the request");
    *request.mutable_spec() = square_spec(kSceneBytes, 32);
    auto answer = std::make_shared<std::promise<absl::StatusOr<std::string>>>();
    submission_.submit(request, [answer](const absl::StatusOr<std::string>& id) { answer->set_value(id); });
    return answer->get_future().get();
  }

  std::vector<std::string> names_;
  std::size_t made_ = 0;
  std::unique_ptr<Journal> journal_ = *open_journal({});
  std::shared_ptr<BlobStore> blobs_ = make_memory_blob_store();
  FarmCore core_{*journal_, *blobs_, options(), [](const absl::Status& why) { ADD_FAILURE() << why; }};
  UserShares shares_{core_};
  JobSubmission submission_{core_, shares_};
};

TEST_F(SubmissionTest, WhatTheSchedulerRefusesIsInNoTable) {
  names_ = {"taken", "free"};
  JobRequest other;
  other.id = "taken";
  other.plan = std::make_shared<const WorkPlan>(WorkPlan::make(square_spec(kSceneBytes, 32)).value());
  {
    const std::lock_guard lock(core_.mutex());
    ASSERT_TRUE(core_.scheduler().add_job(other).ok());
  }
  shares_.note_upload(wire::sha256_hex(kSceneBytes), 7);

  EXPECT_EQ(submit().status().code(), absl::StatusCode::kAlreadyExists);
  {
    const std::lock_guard lock(core_.mutex());
    EXPECT_THAT(core_.jobs().all(), IsEmpty());
  }
  // Sent again, the request is a new one, and the upload is still to be paid for.
  const absl::StatusOr<std::string> again = submit();
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(*again, "free");
  const std::lock_guard lock(core_.mutex());
  ASSERT_THAT(core_.jobs().all(), SizeIs(1));
  EXPECT_EQ(core_.jobs().find("free")->uploaded_bytes, 7u);
}

TEST(Adoption, ThatFailsHasNothingToJournal) {
  Scheduler scheduler(SchedulerOptions{});
  const auto plan = std::make_shared<const WorkPlan>(WorkPlan::make(square_spec(kSceneBytes, 32)).value());
  JobRequest job;
  job.id = "new";
  job.plan = plan;
  ASSERT_TRUE(scheduler.add_job(job).ok());
  Donor donor{.record = {}, .plan = plan, .named = true};
  donor.record.added.id = "old";
  donor.record.isa = "avx2/embree-3.13.5/0badcafe";
  donor.record.results.push_back(
      {.units = {.first = 0}, .digest = std::string(64, 'a'), .stats = "", .host = "h"});
  std::vector<JournalEntry> entries;
  ASSERT_TRUE(adopt_results(scheduler, job, donor, entries).ok());
  EXPECT_THAT(entries, SizeIs(1));
  // It is not new any more.
  entries.clear();
  EXPECT_EQ(adopt_results(scheduler, job, donor, entries).code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(entries, IsEmpty());
}

}  // namespace
}  // namespace tessera::server
