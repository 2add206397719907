// How long jobs, their results and their blobs are kept.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>

#include "store/blobs/blob_store.h"
#include "support/process/temp_dir.h"
#include "unit/server/coordinator_fixture.h"
#include "unit/server/stored_blobs.h"
#include "wire/digest.h"

namespace tessera::server {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;

constexpr hours kYears{24 * 365 * 10};

class RetentionTest : public CoordinatorTest {
 protected:
  CoordinatorOptions options() {
    CoordinatorOptions options;
    options.data_dir = folder_.path();
    options.prune_interval = milliseconds{1};  // every tick of the dispatcher prunes
    options.keep_fetched = kYears;
    options.keep_unfetched = kYears;
    options.clock = &clock_;
    return options;
  }

  std::vector<std::string> jobs() {
    grpc::ClientContext context;
    v1::ListJobsResponse response;
    EXPECT_TRUE(farm_->ListJobs(&context, {}, &response).ok());
    std::vector<std::string> ids;
    for (const v1::JobStatus& status : response.jobs()) ids.push_back(status.job_id());
    return ids;
  }
  bool has(const std::string& id) {
    const std::vector<std::string> ids = jobs();
    return std::find(ids.begin(), ids.end(), id) != ids.end();
  }
  /// Lives on until the job is deleted: for some seconds, as a rule, and never for years.
  void wait_until_gone(const std::string& id) {
    while (has(id)) clock_.live_through(std::chrono::seconds{1});
  }

  /// Renders all units of the jobs submitted so far.
  void render() {
    const std::string worker = register_worker();
    while (true) {
      const v1::LeaseResponse leases = lease(worker, 16);
      if (leases.leases_size() == 0) break;
      for (const v1::Lease& lease : leases.leases()) {
        const std::string payload = payload_for(lease.unit());
        rendered_bytes_ += payload.size();
        ASSERT_TRUE(complete(worker, lease, payload).ok());
      }
    }
    grpc::ClientContext context;
    v1::DeregisterRequest request;
    request.set_worker_id(worker);
    v1::DeregisterResponse response;
    ASSERT_TRUE(work_->Deregister(&context, request, &response).ok());
  }
  void fetch(const std::string& id) {
    v1::WatchJobRequest request;
    request.set_job_id(id);
    ASSERT_FALSE(watch(request).empty());
  }
  v1::JobSpec spec_with_seed(std::uint64_t seed) {
    v1::JobSpec spec = job_spec();
    spec.mutable_view()->set_seed(seed);  // otherwise it would take over results that are there
    return spec;
  }
  bool has_blob(const std::string& bytes) const {
    const std::string digest = wire::sha256_hex(bytes);
    return std::filesystem::exists(folder_.path() / "blobs" / digest.substr(0, 2) / digest);
  }

  support::TempDir folder_;
  std::uint64_t rendered_bytes_ = 0;
};

TEST_F(RetentionTest, AJobThatWasFetchedGoesBeforeOneThatWasNot) {
  CoordinatorOptions short_lived = options();
  short_lived.keep_fetched = std::chrono::seconds{0};
  start(short_lived);
  const std::string fetched = submit(spec_with_seed(1)), unfetched = submit(spec_with_seed(2));
  render();
  const std::string open = submit(spec_with_seed(3));
  fetch(fetched);
  wait_until_gone(fetched);
  EXPECT_TRUE(has(unfetched));
  EXPECT_TRUE(has(open));
  // A restart brings nothing back, and changes nothing of what is kept.
  start(short_lived);
  EXPECT_FALSE(has(fetched));
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "results" / fetched));
  EXPECT_TRUE(has(unfetched));
  fetch(unfetched);
  wait_until_gone(unfetched);
  EXPECT_TRUE(has(open));
}

TEST_F(RetentionTest, WhatNobodyFetchesHasItsTimeToo) {
  CoordinatorOptions short_lived = options();
  short_lived.keep_unfetched = std::chrono::seconds{0};
  start(short_lived);
  const std::string id = submit(job_spec());
  render();
  const std::string other = submit(spec_with_seed(2));
  wait_until_gone(id);
  EXPECT_TRUE(has(other));  // not begun: its time has not come
}

TEST_F(RetentionTest, TooManyBytesTakeFetchedJobsOnlyAndTheOldestFirst) {
  start(options());
  std::vector<std::string> ids;
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    ids.push_back(submit(spec_with_seed(seed)));
    render();
  }
  fetch(ids[0]);
  fetch(ids[2]);
  CoordinatorOptions less = options();
  less.max_result_bytes = rendered_bytes_ - 1;
  start(less);
  wait_until_gone(ids[0]);
  EXPECT_TRUE(has(ids[1]));
  EXPECT_TRUE(has(ids[2]));
  less.max_result_bytes = 0;
  start(less);
  wait_until_gone(ids[2]);
  EXPECT_TRUE(has(ids[1]));  // whatever the size: nobody has its image
}

TEST_F(RetentionTest, ResultsThatWereTakenOverOutliveTheirFirstJob) {
  CoordinatorOptions short_lived = options();
  short_lived.keep_fetched = std::chrono::seconds{0};
  start(short_lived);
  const std::string first = submit(job_spec());
  render();
  const std::string second = submit(job_spec());
  EXPECT_EQ(job(second).units_adopted(), 4u);
  fetch(first);
  wait_until_gone(first);
  for (int round = 0; round < 2; ++round) {
    EXPECT_EQ(job(second).state(), v1::DONE);
    v1::WatchJobRequest request;
    request.set_job_id(second);
    // The whole of it goes once somebody has it; with a later coordinator it is still read from the disk.
    request.set_status_only(round == 0);
    int results = 0;
    for (const v1::WatchJobResponse& message : watch(request)) results += message.results_size();
    EXPECT_EQ(results, round == 0 ? 0 : 4);
    if (round == 0) start(short_lived);
  }
}

TEST_F(RetentionTest, BlobsGoWithTheLastJobThatNeedsThem) {
  CoordinatorOptions short_lived = options();
  short_lived.keep_fetched = std::chrono::seconds{0};
  short_lived.keep_blobs = std::chrono::seconds{0};
  start(short_lived);
  v1::JobSpec both = spec_with_seed(1);
  ASSERT_TRUE(upload("only of the first").ok());
  both.mutable_farm()->add_blobs()->set_digest(wire::sha256_hex("only of the first"));
  const std::string first = submit(both), second = submit(spec_with_seed(2));
  render();
  fetch(first);
  wait_until_gone(first);
  stop();  // it waits for whoever deletes blobs
  EXPECT_FALSE(has_blob("only of the first"));
  EXPECT_TRUE(has_blob("a scene"));
  start(short_lived);
  fetch(second);
  wait_until_gone(second);
  stop();
  EXPECT_FALSE(has_blob("a scene"));
}

TEST(BlobCollection, SparesWhatIsNeededBeingUploadedOrWasAskedForLately) {
  const support::TempDir folder;
  const auto store = make_file_blob_store(folder.path());
  std::filesystem::create_directories(folder.path() / "partial");
  const auto put = [&](const std::string& bytes) {
    store_blob(*store, bytes);
    return wire::sha256_hex(bytes);
  };
  const auto age = [&](const std::filesystem::path& path) {
    std::filesystem::last_write_time(path, std::filesystem::file_time_type::clock::now() - hours{2});
  };
  const auto path_of = [&](const std::string& digest) {
    return folder.path() / "blobs" / digest.substr(0, 2) / digest;
  };
  const std::string needed = put("needed"), asked = put("asked for"), fresh = put("fresh"), old = put("old");
  for (const std::string& digest : {needed, asked, old}) age(path_of(digest));
  const auto reader = store->read(old);
  ASSERT_TRUE(reader.ok());
  EXPECT_TRUE(store->query(asked).complete);

  // Two uploads that broke off, one of which goes on.
  const std::string abandoned = wire::sha256_hex("abandoned"), resumed = wire::sha256_hex("resumed");
  ASSERT_TRUE((*store->write(abandoned, 0))->append("aban").ok());
  const auto writer = store->write(resumed, 0);
  ASSERT_TRUE((*writer)->append("resu").ok());
  for (const std::string& digest : {abandoned, resumed}) age(folder.path() / "partial" / digest);

  const BlobStore::Collected collected =
      store->collect([&](const std::string& digest) { return digest == needed; }, hours{1});
  EXPECT_EQ(collected.blobs, 2u);
  EXPECT_EQ(collected.bytes, 7u);
  for (const std::string& digest : {needed, asked, fresh}) EXPECT_TRUE(store->query(digest).complete);
  EXPECT_FALSE(store->query(old).complete);
  EXPECT_EQ(store->query(abandoned).stored_bytes, 0u);
  // Whoever reads goes on reading, and whoever writes, writing.
  EXPECT_EQ((*reader)->read(0, 10).value(), "old");
  ASSERT_TRUE((*writer)->append("med").ok());
  EXPECT_TRUE((*writer)->finish().ok());
  EXPECT_TRUE(store->query(resumed).complete);
}

}  // namespace
}  // namespace tessera::server
