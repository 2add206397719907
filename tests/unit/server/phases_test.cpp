// Jobs in phases: the coordinator as workers, clients, its disk and its journal see it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <thread>

#include "absl/strings/str_cat.h"
#include "support/phased_job.h"
#include "support/process/temp_dir.h"
#include "unit/server/coordinator_fixture.h"
#include "wire/digest.h"

namespace tessera::server {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Parts 0 to 3, merges 4 and 5, and 6; part 7; 2 x 2 tiles.
constexpr std::uint32_t kFirstRoot = 6, kSecondRoot = 7, kFirstOfPicture = 8, kAllUnits = 12;

class PhasesTest : public CoordinatorTest {
 protected:
  void SetUp() override {
    start(directory_.path());
    worker_ = register_worker();
  }

  v1::JobSpec phased_spec(std::uint32_t ranges = 1) {
    v1::JobSpec spec = job_spec(ranges);
    test::add_test_phases(spec, {4, 1});
    return spec;
  }

  /// Stands for what honest workers make of the unit: its inputs, in brackets.
  static std::string blob_of(const v1::WorkUnit& unit) {
    std::string blob = absl::StrCat(unit.index(), "(");
    for (const v1::BlobRef& input : unit.inputs()) absl::StrAppend(&blob, input.digest().substr(0, 8), " ");
    return blob + ")";
  }

  static std::string payload_of(const std::string& blob) {
    v1::BlobRef ref;
    ref.set_digest(wire::sha256_hex(blob));
    ref.set_size_bytes(blob.size());
    return ref.SerializeAsString();
  }

  grpc::Status finish(const v1::Lease& lease) {
    if (lease.unit().has_tile()) return complete(worker_, lease, payload_for(lease.unit()));
    const std::string blob = blob_of(lease.unit());
    EXPECT_TRUE(upload(blob).ok());
    made_[lease.unit().index()] = wire::sha256_hex(blob);
    return complete(worker_, lease, payload_of(blob));
  }

  std::vector<v1::Lease> lease_all() {
    const v1::LeaseResponse leases = lease(worker_, 100);
    return {leases.leases().begin(), leases.leases().end()};
  }

  /// Does what there is to do before this unit.
  void finish_until(std::uint32_t unit) {
    for (std::vector<v1::Lease> leases = lease_all(); !leases.empty(); leases = lease_all()) {
      for (const v1::Lease& lease : leases) ASSERT_TRUE(finish(lease).ok()) << lease.unit().index();
      if (leases.back().unit().index() + 1 >= unit) return;
    }
  }

  std::filesystem::path blob_file(std::uint32_t unit) const {
    const std::string& digest = made_.at(unit);
    return directory_.path() / "blobs" / digest.substr(0, 2) / digest;
  }

  static std::vector<std::uint32_t> units_of(const std::vector<v1::Lease>& leases) {
    std::vector<std::uint32_t> units;
    for (const v1::Lease& lease : leases) units.push_back(lease.unit().index());
    return units;
  }

  static std::vector<std::string> inputs_of(const v1::Lease& lease) {
    std::vector<std::string> digests;
    for (const v1::BlobRef& input : lease.unit().inputs()) digests.push_back(input.digest());
    return digests;
  }

  support::TempDir directory_;
  std::string worker_;
  std::map<std::uint32_t, std::string> made_;  // digest by unit
};

TEST_F(PhasesTest, StepsFollowEachOtherAndReadWhatWasMade) {
  const std::string id = submit(phased_spec());
  EXPECT_EQ(job(id).units_total(), kAllUnits);
  const std::vector<v1::Lease> parts = lease_all();
  EXPECT_THAT(units_of(parts), ElementsAre(0, 1, 2, 3));
  for (const v1::Lease& lease : parts) EXPECT_THAT(inputs_of(lease), IsEmpty());
  for (std::size_t i = 0; i < 3; ++i) ASSERT_TRUE(finish(parts[i]).ok());
  EXPECT_THAT(lease_all(), IsEmpty()) << "one part is missing";
  ASSERT_TRUE(finish(parts[3]).ok());

  const std::vector<v1::Lease> merges = lease_all();
  EXPECT_THAT(units_of(merges), ElementsAre(4, 5));
  EXPECT_THAT(inputs_of(merges[0]), ElementsAre(made_[0], made_[1], made_[2]));
  EXPECT_THAT(inputs_of(merges[1]), ElementsAre(made_[3]));
  for (const v1::Lease& lease : merges) ASSERT_TRUE(finish(lease).ok());
  finish_until(kSecondRoot);
  const std::vector<v1::Lease> second = lease_all();
  EXPECT_THAT(units_of(second), ElementsAre(kSecondRoot));
  EXPECT_THAT(inputs_of(second[0]), ElementsAre(made_[kFirstRoot]));
  ASSERT_TRUE(finish(second[0]).ok());

  const std::vector<v1::Lease> tiles = lease_all();
  EXPECT_THAT(units_of(tiles), ElementsAre(8, 9, 10, 11));
  for (const v1::Lease& lease : tiles) {
    EXPECT_THAT(inputs_of(lease), ElementsAre(made_[kFirstRoot], made_[kSecondRoot]));
    ASSERT_TRUE(finish(lease).ok());
  }
  EXPECT_EQ(job(id).state(), v1::DONE);

  v1::WatchJobRequest request;
  request.set_job_id(id);
  std::size_t results = 0;
  for (const v1::WatchJobResponse& message : watch(request)) {
    for (const v1::UnitResult& result : message.results()) {
      EXPECT_TRUE(result.unit().has_tile()) << "clients get pixels only";
      ++results;
    }
  }
  EXPECT_EQ(results, 4u);
}

TEST_F(PhasesTest, AJobWhosePhaseFailsIsIncompleteAndMayBeRetried) {
  v1::JobSpec spec = job_spec();
  test::add_test_phases(spec, {1, 1});
  const std::string id = submit(spec);
  for (int i = 0; i < 3; ++i) {
    const std::vector<v1::Lease> part = lease_all();
    ASSERT_THAT(units_of(part), ElementsAre(0));
    ASSERT_TRUE(fail(worker_, part[0], "no luck").ok());
  }
  EXPECT_EQ(job(id).state(), v1::INCOMPLETE) << job(id).error();
  EXPECT_THAT(job(id).error(), HasSubstr("1 of 6 units were set aside"));
  grpc::ClientContext context;
  v1::RetryJobRequest request;
  request.set_job_id(id);
  v1::RetryJobResponse response;
  ASSERT_TRUE(farm_->RetryJob(&context, request, &response).ok());
  finish_until(kAllUnits);
  EXPECT_EQ(job(id).state(), v1::DONE);
}

TEST_F(PhasesTest, AResultMustNameABlobThatIsThere) {
  submit(phased_spec());
  const v1::Lease part = lease_all().front();
  const grpc::Status missing = complete(worker_, part, payload_of("never uploaded"));
  EXPECT_EQ(missing.error_code(), grpc::INVALID_ARGUMENT);
  EXPECT_THAT(missing.error_message(), HasSubstr("there is no blob"));
  EXPECT_EQ(complete(worker_, part, "pixels").error_code(), grpc::INVALID_ARGUMENT);
  EXPECT_TRUE(finish(part).ok());
}

TEST_F(PhasesTest, ARestartGoesOnWithinAReduction) {
  const std::string id = submit(phased_spec());
  finish_until(4);
  const v1::Lease merge = lease_all().front();
  ASSERT_TRUE(finish(merge).ok());
  start(directory_.path());
  worker_ = register_worker();
  const std::vector<v1::Lease> rest = lease_all();
  EXPECT_THAT(units_of(rest), ElementsAre(5)) << "the other merge is there";
  EXPECT_THAT(inputs_of(rest[0]), ElementsAre(made_[3])) << "inputs are known after a restart";
  ASSERT_TRUE(finish(rest[0]).ok());
  finish_until(kAllUnits);
  EXPECT_EQ(job(id).state(), v1::DONE);
}

TEST_F(PhasesTest, ALostBlobIsMadeAnewAndAllThatWasMadeOfIt) {
  const std::string id = submit(phased_spec());
  finish_until(kFirstOfPicture);
  const std::vector<v1::Lease> tiles = lease_all();
  ASSERT_EQ(tiles.size(), 4u);
  ASSERT_TRUE(finish(tiles[0]).ok());
  EXPECT_EQ(job(id).units_done(), 9u);
  std::filesystem::remove(blob_file(kFirstRoot));
  // Whoever cannot read what a tile needs says so; the tile is not to blame.
  ASSERT_TRUE(fail(worker_, tiles[1], "there is no such blob").ok());
  EXPECT_EQ(job(id).revision(), 3u) << "the tile, the second phase and the first one's root";
  EXPECT_EQ(job(id).failures(), 0u);
  const std::vector<v1::Lease> again = lease_all();
  EXPECT_THAT(units_of(again), ElementsAre(kFirstRoot));
  // Until it is there, nothing that is made of it counts.
  const grpc::Status stale = finish(tiles[2]);
  EXPECT_EQ(stale.error_code(), grpc::FAILED_PRECONDITION);
  EXPECT_THAT(stale.error_message(), HasSubstr("count no more"));
  ASSERT_TRUE(finish(again[0]).ok());
  finish_until(kAllUnits);
  EXPECT_EQ(job(id).state(), v1::DONE);
}

TEST_F(PhasesTest, ALostBlobIsNoticedByTheWorkerThatNeedsIt) {
  const std::string id = submit(phased_spec());
  finish_until(4);
  std::filesystem::remove(blob_file(1));
  std::filesystem::remove(blob_file(2));
  const std::vector<v1::Lease> merges = lease_all();
  EXPECT_THAT(units_of(merges), ElementsAre(4, 5)) << "a lease is given out without a look at the disk";
  EXPECT_THAT(inputs_of(merges[0]), ElementsAre(made_[0], made_[1], made_[2]));
  ASSERT_TRUE(fail(worker_, merges[1], "out of memory").ok());
  EXPECT_EQ(job(id).revision(), 0u) << "all that this one reads is there";
  EXPECT_EQ(job(id).failures(), 1u);
  ASSERT_TRUE(fail(worker_, merges[0], "there is no such blob").ok());
  EXPECT_EQ(job(id).failures(), 1u) << "the merge is not to blame";
  EXPECT_THAT(units_of(lease_all()), ElementsAre(1, 2));
  EXPECT_THAT(job(id).notes(), ElementsAre(HasSubstr("is gone"), HasSubstr("is gone")));
}

TEST_F(PhasesTest, LostTilesOfAJobThatWasOverReadWhatItsPhasesMade) {
  const std::string id = submit(phased_spec());
  finish_until(kAllUnits);
  ASSERT_EQ(job(id).state(), v1::DONE);
  stop();
  std::filesystem::remove(directory_.path() / "results" / id);
  start(directory_.path());
  worker_ = register_worker();
  std::jthread watcher([&] {
    v1::WatchJobRequest request;
    request.set_job_id(id);
    watch(request);
  });
  for (int tiles = 0; tiles < 4;) {
    const v1::LeaseResponse leases = lease(worker_, 100, std::chrono::minutes{1});
    for (const v1::Lease& lease : leases.leases()) {
      ASSERT_THAT(inputs_of(lease), ElementsAre(made_[kFirstRoot], made_[kSecondRoot]));
      ASSERT_TRUE(finish(lease).ok());
      ++tiles;
    }
  }
  watcher.join();
  EXPECT_EQ(job(id).state(), v1::DONE);
}

TEST_F(PhasesTest, MoreSamplesOfTheSameJobTakeItsPhasesOver) {
  submit(phased_spec());
  finish_until(kAllUnits);
  const std::string more = submit(phased_spec(2));
  EXPECT_EQ(job(more).units_adopted(), kAllUnits);
  const std::vector<v1::Lease> tiles = lease_all();
  EXPECT_THAT(units_of(tiles), ElementsAre(12, 13, 14, 15));
  EXPECT_THAT(inputs_of(tiles[0]), ElementsAre(made_[kFirstRoot], made_[kSecondRoot]));
}

TEST_F(PhasesTest, WithoutThePhasesNothingIsTakenOver) {
  submit(phased_spec());
  finish_until(kAllUnits);
  std::filesystem::remove(blob_file(kSecondRoot));
  EXPECT_EQ(job(submit(phased_spec(2))).units_adopted(), 0u);
  v1::JobSpec other = phased_spec(2);
  other.mutable_cut()->mutable_phases(0)->set_parts(5);
  EXPECT_EQ(job(submit(other)).units_adopted(), 0u) << "another map, another picture";
}

}  // namespace
}  // namespace tessera::server
