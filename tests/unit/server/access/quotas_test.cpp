// Upper bounds of what one client may ask of the farm.
#include "service/farm/quotas.h"

#include <gmock/gmock.h>

#include <future>
#include <limits>

#include "service/farm/farm.h"
#include "service/farm/job_control.h"
#include "service/farm/job_submission.h"
#include "service/farm/unclaimed_uploads.h"
#include "service/farm/user_shares.h"
#include "service/job/user_blobs.h"
#include "support/process/temp_dir.h"
#include "unit/server/coordinator_fixture.h"
#include "unit/server/requests.h"

namespace tessera::server {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const Caller kAlice{.role = Role::kClient, .user = "alice"};
const Caller kBob{.role = Role::kClient, .user = "bob"};
const Caller kAdmin{.role = Role::kAdmin, .user = "admin"};

/// Calls the farm as callers with certificates do.
class QuotasTest : public CoordinatorTest {
 protected:
  void start_with(const Quotas& quotas) {
    CoordinatorOptions options;
    options.data_dir = directory_.path();
    options.quotas = quotas;
    options.late_results = std::chrono::milliseconds{0};
    options.clock = &clock_;
    start(options);
  }
  Farm& farm() { return coordinator_->farm(); }

  /// A job of four units of that client, which shares no result with others.
  absl::StatusOr<std::string> submit_as(const Caller& who, std::int32_t priority = 0,
                                        const std::string& scene = "a scene") {
    EXPECT_TRUE(upload(scene).ok());
    v1::SubmitJobRequest request;
    request.set_request_id("request " + std::to_string(++requests_));
    request.set_fresh(true);
    *request.mutable_spec() = square_spec(scene, 32);
    request.mutable_spec()->mutable_farm()->set_user(who.user);
    request.mutable_spec()->mutable_farm()->set_priority(priority);
    std::promise<absl::StatusOr<std::string>> done;
    farm().submission().submit(
        request, [&](absl::StatusOr<std::string> id) { done.set_value(std::move(id)); }, who);
    return done.get_future().get();
  }
  absl::Status set_priority(const std::string& job, std::int32_t priority, const Caller& who) {
    v1::AdjustJobRequest request;
    request.set_job_id(job);
    request.set_priority(priority);
    std::promise<absl::Status> done;
    farm().jobs().adjust(
        request, [&](const absl::StatusOr<v1::JobStatus>& status) { done.set_value(status.status()); }, who);
    return done.get_future().get();
  }
  absl::Status retry(const std::string& job, const Caller& who) {
    std::promise<absl::Status> done;
    farm().jobs().retry(
        job, [&](const absl::StatusOr<v1::JobStatus>& status) { done.set_value(status.status()); }, who);
    return done.get_future().get();
  }
  void cancel(const std::string& job) {
    std::promise<void> done;
    farm().jobs().cancel(job, [&](const absl::StatusOr<v1::JobStatus>&) { done.set_value(); });
    done.get_future().get();
  }
  void erase(const std::string& job) {
    std::promise<absl::Status> done;
    farm().jobs().delete_job(job, [&](const absl::Status& status) { done.set_value(status); });
    EXPECT_TRUE(done.get_future().get().ok());
  }
  /// Does the job but for its last unit, which fails until it is set aside.
  void leave_incomplete(const std::string& job) {
    const std::string worker = register_worker();
    for (int done = 0; this->job(job).state() != v1::INCOMPLETE;) {
      const v1::LeaseResponse leases = lease(worker, 1);
      ASSERT_EQ(leases.leases_size(), 1);
      const v1::Lease& lease = leases.leases(0);
      if (++done < 4) {
        ASSERT_TRUE(complete(worker, lease, payload_for(lease.unit())).ok());
      } else {
        ASSERT_TRUE(fail(worker, lease, "no").ok());
      }
    }
  }

  support::TempDir directory_;
};

TEST_F(QuotasTest, AClientsPriorityIsBoundedWhereverItIsAskedFor) {
  start_with({.priority = {.of_all = 0, .of_some = {{"bob", 7}}}});
  const auto is_refused = [](const absl::Status& status, const char* asked, const char* most) {
    EXPECT_TRUE(absl::IsPermissionDenied(status)) << status;
    EXPECT_THAT(
        std::string(status.message()),
        AllOf(HasSubstr(asked), HasSubstr(most), HasSubstr("--max-priority"), HasSubstr("administrator")));
  };
  constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max();
  is_refused(submit_as(kAlice, kMost).status(), "2147483647", "which is 0");
  is_refused(submit_as(kBob, 8).status(), "priority 8", "which is 7");
  EXPECT_TRUE(submit_as(kBob, 7).ok());
  EXPECT_TRUE(submit_as(kAdmin, kMost).ok()) << "administrators stand above";

  const absl::StatusOr<std::string> mine = submit_as(kAlice, -3);
  ASSERT_TRUE(mine.ok()) << mine.status();
  is_refused(set_priority(*mine, 1, kAlice), "priority 1", "which is 0");
  EXPECT_TRUE(set_priority(*mine, kMost, kAdmin).ok());
  EXPECT_TRUE(set_priority(*mine, 0, kAlice).ok());
  EXPECT_EQ(job(*mine).priority(), 0);
}

TEST_F(QuotasTest, ARetryAsksForThePriorityAgain) {
  start_with({});
  const absl::StatusOr<std::string> mine = submit_as(kAlice);
  ASSERT_TRUE(mine.ok());
  ASSERT_TRUE(set_priority(*mine, 5, kAdmin).ok());
  leave_incomplete(*mine);
  const absl::Status refused = retry(*mine, kAlice);
  EXPECT_TRUE(absl::IsPermissionDenied(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()), HasSubstr("--max-priority"));
  EXPECT_TRUE(retry(*mine, kAdmin).ok());
}

TEST_F(QuotasTest, OpenJobsAreCountedByUser) {
  start_with({.open_jobs = {.of_all = 2, .of_some = {{"bob", 0}}}});
  const absl::StatusOr<std::string> first = submit_as(kAlice);
  ASSERT_TRUE(first.ok());
  leave_incomplete(*first);
  const absl::StatusOr<std::string> second = submit_as(kAlice), third = submit_as(kAlice);
  ASSERT_TRUE(second.ok() && third.ok()) << "the first one is over";
  const absl::Status refused = submit_as(kAlice).status();
  EXPECT_TRUE(absl::IsResourceExhausted(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()),
              AllOf(HasSubstr("'alice' would have 3 jobs"), HasSubstr("the quota is 2"),
                    HasSubstr("--max-open-jobs"), HasSubstr("administrator")));
  EXPECT_EQ(retry(*first, kAlice), refused) << "an incomplete job would be open again";
  EXPECT_TRUE(absl::IsResourceExhausted(submit_as(kBob).status()));
  EXPECT_TRUE(submit_as(kAdmin).ok());
  cancel(*second);
  EXPECT_TRUE(retry(*first, kAlice).ok());
}

TEST_F(QuotasTest, UnitsAreCountedByUser) {
  start_with({.units = {.of_all = 8}});
  const absl::StatusOr<std::string> first = submit_as(kAlice);
  ASSERT_TRUE(first.ok());
  ASSERT_TRUE(submit_as(kAlice).ok());
  const absl::Status refused = submit_as(kAlice).status();
  EXPECT_TRUE(absl::IsResourceExhausted(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()),
              AllOf(HasSubstr("12 units"), HasSubstr("the quota is 8"), HasSubstr("--max-open-units")));
  EXPECT_TRUE(submit_as(kBob).ok()) << "one user does not take another's";
  EXPECT_TRUE(submit_as(kAdmin).ok());
}

TEST_F(QuotasTest, BytesOfBlobsAreCountedByUserUntilNobodyNamesThem) {
  start_with({.blob_bytes = {.of_all = 15}});
  const absl::StatusOr<std::string> first = submit_as(kAlice, 0, "ten bytes.");
  ASSERT_TRUE(first.ok()) << first.status();
  const absl::StatusOr<std::string> again = submit_as(kAlice, 0, "ten bytes.");
  ASSERT_TRUE(again.ok()) << "the same bytes: " << again.status();
  const absl::Status refused = submit_as(kAlice, 0, "six b.").status();
  EXPECT_TRUE(absl::IsResourceExhausted(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()), AllOf(HasSubstr("'alice'"), HasSubstr("--max-blobs")));
  EXPECT_TRUE(submit_as(kBob, 0, "ten bytes.").ok()) << "each user has a quota";
  EXPECT_TRUE(submit_as(kAdmin, 0, "more than fifteen").ok());
  cancel(*first);
  erase(*first);
  EXPECT_FALSE(submit_as(kAlice, 0, "six b.").ok()) << "the other job names them still";
  start_with({.blob_bytes = {.of_all = 15}});
  EXPECT_FALSE(submit_as(kAlice, 0, "six b.").ok()) << "after a restart, too";
  cancel(*again);
  erase(*again);
  EXPECT_TRUE(submit_as(kAlice, 0, "six b.").ok());
}

TEST_F(QuotasTest, UploadsCountAgainstWhoeverSendsThem) {
  start_with({.blob_bytes = {.of_all = 15}});
  const auto blob = [](const std::string& bytes, std::uint64_t size) {
    v1::BlobRef ref;
    ref.set_digest(wire::sha256_hex(bytes));
    ref.set_size_bytes(size);
    return ref;
  };
  EXPECT_TRUE(farm().shares().begin_upload(blob("one", 10), kAlice).ok());
  EXPECT_TRUE(farm().shares().begin_upload(blob("one", 10), kAlice).ok()) << "it goes on";
  EXPECT_TRUE(absl::IsResourceExhausted(farm().shares().begin_upload(blob("two", 6), kAlice)));
  EXPECT_TRUE(farm().shares().begin_upload(blob("two", 6), kBob).ok());
  EXPECT_TRUE(farm().shares().begin_upload(blob("three", 1000), kAdmin).ok());
  EXPECT_FALSE(submit_as(kAlice, 0, "six b.").ok()) << "what was uploaded counts with what is submitted";
  EXPECT_TRUE(farm().shares().begin_upload(blob("one", 10), kBob).code() ==
              absl::StatusCode::kResourceExhausted);
}

TEST(QuotaOptions, AreNumbersForAllAndForSingleUsers) {
  Quotas quotas;
  EXPECT_TRUE(read_quota("10", quotas.priority).ok());
  EXPECT_TRUE(read_quota("ada=-5", quotas.priority).ok());
  EXPECT_EQ(quotas.priority.of("ada"), -5);
  EXPECT_EQ(quotas.priority.of("bob"), 10);
  EXPECT_TRUE(read_gigabytes("ada=0.5", quotas.blob_bytes).ok());
  EXPECT_EQ(quotas.blob_bytes.of("ada"), 500'000'000u);
  EXPECT_EQ(quotas.blob_bytes.of("bob"), Quotas::kUnbounded);
  for (const char* wrong : {"", "=5", "ada=", "ada", "1.5", "99999999999", "5 ", "ada=5=6"})
    EXPECT_TRUE(absl::IsInvalidArgument(read_quota(wrong, quotas.priority))) << wrong;
  for (const char* wrong : {"-1", "nan", "inf", "1e300", "GB"})
    EXPECT_TRUE(absl::IsInvalidArgument(read_gigabytes(wrong, quotas.blob_bytes))) << wrong;
}

TEST(UserBlobs, CountEachBlobOnceAUser) {
  UserBlobs blobs;
  v1::JobSpec spec = square_spec("scene", 16);
  spec.mutable_farm()->set_user("ada");
  spec.mutable_farm()->add_blobs()->set_digest(wire::sha256_hex("mesh"));
  EXPECT_EQ(blobs.bytes_with(spec, {3, 4}), 7u);
  blobs.add(spec, {3, 4});
  EXPECT_EQ(blobs.bytes_with(spec, {3, 4}), 7u);
  blobs.add(spec, {3, 4});
  EXPECT_EQ(blobs.bytes_of("ada"), 7u);
  EXPECT_EQ(blobs.bytes_of("bob"), 0u);
  EXPECT_EQ(blobs.size_of(wire::sha256_hex("mesh")), 4u);
  blobs.remove(spec);
  EXPECT_EQ(blobs.bytes_of("ada"), 7u);
  blobs.remove(spec);
  EXPECT_EQ(blobs.bytes_of("ada"), 0u);
  EXPECT_FALSE(blobs.size_of(wire::sha256_hex("mesh")));
}

TEST(UnclaimedUploads, CountAgainstTheirSender) {
  const UnclaimedUploads::TimePoint start{};
  UnclaimedUploads uploads(std::chrono::hours{1});
  const v1::JobSpec spec = square_spec("scene", 16);
  uploads.begin(spec.content().scene(), 100, "ada", start);
  uploads.begin("another", 7, "ada", start);
  uploads.note("another", 7, start);
  EXPECT_EQ(uploads.held_by("ada"), 107u);
  EXPECT_EQ(uploads.held_by("ada", spec), 7u);
  EXPECT_EQ(uploads.held_by("ada", "another"), 100u);
  uploads.begin("another", 7, "bob", start);
  EXPECT_EQ(uploads.held_by("ada"), 100u);
  EXPECT_EQ(uploads.held_by("bob"), 7u);
  EXPECT_EQ(uploads.claim(spec), 0u) << "nothing of it was sent";
  EXPECT_EQ(uploads.held_by("ada"), 0u);
  uploads.note("third", 1, start + std::chrono::hours{3});
  EXPECT_EQ(uploads.held_by("bob"), 0u) << "the blob is gone by now";
  EXPECT_EQ(uploads.claim(square_spec("another", 16)), 0u);
}

}  // namespace
}  // namespace tessera::server
