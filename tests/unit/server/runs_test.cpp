// Units that are leased, returned and kept as one: the coordinator as workers, clients and its journal see
// it.
#include <gtest/gtest.h>

#include <map>
#include <set>
#include <vector>

#include "support/process/temp_dir.h"
#include "unit/server/coordinator_fixture.h"
#include "wire/digest.h"

namespace tessera::server {
namespace {

constexpr std::uint32_t kRanges = 16;
constexpr std::uint32_t kRunUnits = 4 * kRanges;  // 2 x 2 tiles
constexpr std::chrono::milliseconds kTook{1};     // however long the test takes for it

class RunsTest : public CoordinatorTest {
 protected:
  void SetUp() override {
    start(directory_.path());
    worker_ = register_worker();
  }

  /// Does what there is to do until `results` more results are in, or nothing is left. Returns the ranges of
  /// each.
  std::vector<std::uint32_t> render(std::size_t results = kRunUnits) {
    std::vector<std::uint32_t> ranges;
    while (ranges.size() < results) {
      const v1::LeaseResponse leases = lease(worker_, 1);
      if (leases.leases().empty()) break;
      const v1::Lease& lease = leases.leases(0);
      EXPECT_TRUE(complete(worker_, lease, payload_for(lease.unit()), kTook).ok());
      ranges.push_back(std::max(lease.token().ranges(), 1u));
      last_ = lease;
    }
    return ranges;
  }

  /// Every sample of every pixel must be in exactly one result. Returns how many results there are.
  int expect_whole(const std::string& id) {
    v1::WatchJobRequest request;
    request.set_job_id(id);
    // Tiles are named by their corners.
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::set<std::uint32_t>> ranges_by_tile;
    int results = 0;
    std::uint32_t units = 0;
    for (const v1::WatchJobResponse& message : watch(request)) {
      for (const v1::UnitResult& result : message.results()) {
        const v1::TileUnit& tile = result.unit().tile();
        EXPECT_EQ(result.payload(), payload_for(result.unit()));
        EXPECT_EQ(tile.samples().end() - tile.samples().begin(), 4 * result.ranges());
        for (std::uint32_t i = tile.samples().begin(); i < tile.samples().end(); i += 4) {
          EXPECT_TRUE(ranges_by_tile[std::pair(tile.pixels().x0(), tile.pixels().y0())].insert(i).second)
              << "came twice";
          ++units;
        }
        ++results;
      }
    }
    EXPECT_EQ(units, kRunUnits);
    return results;
  }

  support::TempDir directory_;
  std::string worker_;
  v1::Lease last_;
};

TEST_F(RunsTest, OneResultOfManyUnitsIsWhatTheClientGets) {
  const std::string id = submit(job_spec(kRanges));
  const std::vector<std::uint32_t> ranges = render();
  EXPECT_LT(ranges.size(), kRunUnits) << "these units cost nothing";
  EXPECT_EQ(ranges.front(), 1u) << "it was not known yet";
  const v1::JobStatus status = job(id);
  EXPECT_EQ(status.state(), v1::DONE);
  EXPECT_EQ(status.units_done(), kRunUnits);
  EXPECT_EQ(expect_whole(id), static_cast<int>(ranges.size()));
}

TEST_F(RunsTest, WithoutRunsThereIsAResultAUnit) {
  CoordinatorOptions options;
  options.longest_run = std::chrono::milliseconds{0};
  start(std::move(options));
  worker_ = register_worker();
  const std::string id = submit(job_spec(kRanges));
  EXPECT_EQ(render().size(), kRunUnits);
  EXPECT_EQ(expect_whole(id), static_cast<int>(kRunUnits));
}

TEST_F(RunsTest, ARestartedCoordinatorKnowsThem) {
  const std::string id = submit(job_spec(kRanges));
  const std::vector<std::uint32_t> before = render(4);
  const std::uint32_t done = job(id).units_done();
  EXPECT_GT(done, before.size());
  start(directory_.path());
  worker_ = register_worker();
  EXPECT_EQ(job(id).units_done(), done);
  EXPECT_TRUE(complete(worker_, last_, payload_for(last_.unit())).ok()) << "the same once more";
  EXPECT_EQ(complete(worker_, last_, payload_for(last_.unit(), /*seed=*/1)).error_code(),
            grpc::StatusCode::ALREADY_EXISTS);
  const std::vector<std::uint32_t> after = render();
  EXPECT_EQ(expect_whole(id), static_cast<int>(before.size() + after.size()));
  start(directory_.path());
  EXPECT_EQ(job(id).units_done(), kRunUnits) << "of a job that is over";
  EXPECT_EQ(expect_whole(id), static_cast<int>(before.size() + after.size()));
}

TEST_F(RunsTest, AJobOfEqualContentTakesThemOver) {
  const std::string first = submit(job_spec(kRanges));
  render();
  const std::string second = submit(job_spec(kRanges));
  EXPECT_EQ(job(second).state(), v1::DONE);
  EXPECT_EQ(job(second).units_adopted(), kRunUnits);
  EXPECT_EQ(expect_whole(second), expect_whole(first));
}

TEST_F(RunsTest, MoreSamplesTakeOverRunsThatAreTheirNodes) {
  submit(job_spec(kRanges / 2));
  render();
  const std::string more = submit(job_spec(kRanges));
  EXPECT_EQ(job(more).units_adopted(), kRunUnits / 2);
  render();
  expect_whole(more);
}

TEST_F(RunsTest, AResultMustBeOfTheRunThatItNames) {
  submit(job_spec(kRanges));
  render(1);
  v1::Lease one = lease(worker_, 1).leases(0);
  const std::string payload = payload_for(one.unit());
  one.mutable_token()->set_ranges(2);
  EXPECT_FALSE(complete(worker_, one, payload).ok()) << "half of it";
  one.mutable_token()->set_ranges(3);
  EXPECT_FALSE(complete(worker_, one, payload).ok()) << "no node";
  one.mutable_token()->set_ranges(2 * kRanges);
  EXPECT_FALSE(complete(worker_, one, payload).ok()) << "more than there is";
}

TEST_F(RunsTest, ALeaseIsSealedForTheRunThatWasGranted) {
  submit(job_spec(kRanges));
  render(6);
  const v1::Lease granted = lease(worker_, 1).leases(0);
  ASSERT_GT(granted.token().ranges(), 1u);
  v1::Lease first = granted;
  first.mutable_token()->set_ranges(1);
  v1::SampleRange& samples = *first.mutable_unit()->mutable_tile()->mutable_samples();
  samples.set_end(samples.begin() + 4);
  start(directory_.path());  // only the seal says what was granted
  worker_ = register_worker();
  EXPECT_EQ(complete(worker_, first, payload_for(first.unit())).error_code(),
            grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_TRUE(complete(worker_, granted, payload_for(granted.unit())).ok());
}

TEST_F(RunsTest, ARunThatFailsIsToldAsOne) {
  const std::string id = submit(job_spec(kRanges));
  render(6);
  const v1::Lease granted = lease(worker_, 1).leases(0);
  ASSERT_GT(granted.token().ranges(), 1u);
  EXPECT_TRUE(fail(worker_, granted, "the texture is gone").ok());
  const v1::JobStatus status = job(id);
  ASSERT_EQ(status.latest_failures_size(), 1);
  EXPECT_EQ(status.latest_failures(0).unit_index(), granted.unit().index());
  EXPECT_EQ(status.latest_failures(0).ranges(), granted.token().ranges());
  start(directory_.path());
  worker_ = register_worker();
  // The third begins at a range that is divided by two: a run, if it were not known that they failed.
  for (std::uint32_t unit = 0; unit < 3; ++unit) {
    const v1::Lease piece = lease(worker_, 1).leases(0);
    EXPECT_EQ(piece.unit().index(), granted.unit().index() + 4 * unit);
    EXPECT_EQ(piece.token().ranges(), 0u) << "in pieces, also after a restart";
    EXPECT_TRUE(complete(worker_, piece, payload_for(piece.unit()), kTook).ok());
  }
}

}  // namespace
}  // namespace tessera::server
