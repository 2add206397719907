#include "service/farm/job_keeper.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "service/farm/unclaimed_uploads.h"
#include "unit/server/manual_clock.h"
#include "unit/server/requests.h"

namespace tessera::server {
namespace {

using std::chrono::hours;
using std::chrono::minutes;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class JobKeeperTest : public testing::Test {
 protected:
  JobEntry& add(const std::string& id, bool fetched) {
    return jobs_.add({.id = id,
                      .request_id = id,
                      .shape = JobShape::make(square_spec("scene", 16)).value(),
                      .past = std::nullopt,
                      .stats = {},
                      .hosts = {},
                      .units_by_sequence = {},
                      .past_revoked = {},
                      .fetched = fetched,
                      .durable_end = true},
                     {5});
  }

  std::vector<std::string> old_jobs_after(std::chrono::milliseconds time) {
    clock_.advance(time);
    keeper_.live_on();
    return keeper_.old_jobs(jobs_, [](const JobEntry&) { return v1::DONE; });
  }

  ManualClock clock_;
  std::unique_ptr<BlobStore> blobs_ = make_memory_blob_store();
  JobTable jobs_;
  JobKeeper keeper_{{.fetched = hours{1},
                     .unfetched = hours{10},
                     .max_bytes = 100,
                     .blobs = hours{1},
                     .interval = minutes{1}},
                    *blobs_,
                    clock_,
                    {}};
};

TEST_F(JobKeeperTest, AJobThatWasFetchedGoesBeforeOneThatWasNot) {
  add("fetched", true);
  add("unfetched", false);
  add("open", false).durable_end = false;
  EXPECT_THAT(old_jobs_after(minutes{1}), IsEmpty()) << "they ended now";
  EXPECT_THAT(old_jobs_after(minutes{59}), IsEmpty());
  EXPECT_THAT(old_jobs_after(minutes{1}), ElementsAre("fetched"));
  EXPECT_THAT(old_jobs_after(hours{9}), ElementsAre("fetched", "unfetched"));
  EXPECT_THAT(old_jobs_after(hours{1000}), ElementsAre("fetched", "unfetched"));
}

TEST_F(JobKeeperTest, TooManyBytesTakeFetchedJobsOnlyAndTheOldestFirst) {
  for (const char* id : {"first", "second", "third"}) add(id, true).result_bytes = 60;
  EXPECT_THAT(old_jobs_after(minutes{1}), ElementsAre("first", "second"));
  for (const auto& entry : jobs_.all()) entry->fetched = false;
  EXPECT_THAT(old_jobs_after(minutes{1}), IsEmpty()) << "nobody has these images";
}

TEST_F(JobKeeperTest, LooksAfterEachInterval) {
  EXPECT_TRUE(keeper_.is_due());
  EXPECT_FALSE(keeper_.is_due());
  clock_.advance(minutes{1});
  EXPECT_TRUE(keeper_.is_due());
}

TEST_F(JobKeeperTest, AnUploadIsToldToOneJob) {
  const UnclaimedUploads::TimePoint start{};
  UnclaimedUploads uploads(std::chrono::hours{1});
  const v1::JobSpec spec = square_spec("scene", 16);
  uploads.note(spec.content().scene(), 5, start);
  uploads.note(spec.content().scene(), 7, start);
  EXPECT_EQ(uploads.claim(spec), 12u);
  EXPECT_EQ(uploads.claim(spec), 0u);
  uploads.note(spec.content().scene(), 5, start);
  uploads.forget(spec.content().scene());
  EXPECT_EQ(uploads.claim(spec), 0u);
}

TEST_F(JobKeeperTest, AnUploadThatNobodyNamesIsForgotten) {
  using std::chrono::minutes;
  const UnclaimedUploads::TimePoint start{};
  UnclaimedUploads uploads(minutes{60});
  const v1::JobSpec spec = square_spec("scene", 16);
  uploads.note(spec.content().scene(), 5, start + minutes{90});
  uploads.note("another", 1, start + minutes{151});
  uploads.note(spec.content().scene(), 7, start + minutes{151});
  EXPECT_EQ(uploads.claim(spec), 12u) << "it is an hour old";
  uploads.note(spec.content().scene(), 5, start + minutes{160});
  uploads.note("another", 1, start + minutes{220});
  uploads.note("another", 1, start + minutes{281});
  EXPECT_EQ(uploads.claim(spec), 0u) << "it is two hours old";
  uploads.note(spec.content().scene(), 5, start + minutes{290});
  uploads.note("another", 1, start + minutes{900});
  EXPECT_EQ(uploads.claim(spec), 0u) << "nothing came for ten hours";
}

}  // namespace
}  // namespace tessera::server
