// A real coordinator and hundreds of workers over real connections: nothing is lost, and everybody has a
// share. How fast that is says farm_load; here no time is asserted, for the machine may be busy.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <thread>

#include "soak/load/farm_under_load.h"
#include "soak/load/wait_for.h"
#include "support/long_form.h"

namespace tessera::load {
namespace {

using std::chrono::milliseconds;
using test::long_form;

// Reached only when something hangs.

class LoadTest : public testing::Test {
 protected:
  void submit(const JobsOptions& options) {
    const auto submitted = farm_.submit(options, progress_);
    ASSERT_TRUE(submitted.ok()) << submitted.status();
    jobs_ = *submitted;
  }

  std::unique_ptr<StubFleet> fleet(const FleetOptions& options) {
    auto fleet = std::make_unique<StubFleet>(
        farm_.address(), options,
        [this](const std::string& job, std::uint32_t unit) { progress_.completed(job, unit); });
    fleet->start();
    return fleet;
  }

  /// Every unit of every job is there once, as it was rendered.
  void expect_all_results() {
    for (const std::string& job : jobs_) {
      std::set<std::uint32_t> seen;
      client::FarmClient::WatchHandlers handlers;
      handlers.result = [&](const v1::UnitResult& result) {
        EXPECT_EQ(result.sequence(), seen.size() + 1);
        EXPECT_TRUE(seen.insert(result.unit().index()).second)
            << "unit " << result.unit().index() << " came twice";
        EXPECT_EQ(result.payload(), stub_result(result.unit()));
        return absl::OkStatus();
      };
      const absl::StatusOr<v1::JobStatus> status = farm_.client().watch(job, handlers, {});
      ASSERT_TRUE(status.ok()) << status.status();
      EXPECT_EQ(status->state(), v1::DONE);
      EXPECT_EQ(seen.size(), status->units_total());
    }
  }

  FarmUnderLoad farm_{TESSERA_SERVER_PROGRAM, {"--log-level", "warning", "--order", "fair"}};
  Progress progress_;
  std::vector<std::string> jobs_;
};

TEST_F(LoadTest, JobsOfSeveralUsersShareTheFarm) {
  submit({.jobs = 10, .users = 5, .scenes = 1, .units = 400});
  const auto workers = fleet({.workers = 200, .threads_per_worker = 1, .unit_time = milliseconds(100)});
  ASSERT_TRUE(wait_for([&] { return progress_.all_done(); }))
      << progress_.done() << " of " << progress_.wanted();
  EXPECT_EQ(workers->tally().refused, 0u);
  // With --order fair: a user's jobs go together. A worker has 3 units at most in its hands, and all jobs
  // nearly the same number of all that are out, at any time: 60 of the 400. A unit takes 50 to 150 ms, so a
  // job's rate fluctuates by less than a part in five, and what is out when the first job ends counts for
  // none.
  const std::vector<std::uint64_t> shares = progress_.shares();
  const auto [least, most] = std::minmax_element(shares.begin(), shares.end());
  EXPECT_LE(static_cast<double>(*most), 1.5 * static_cast<double>(*least)) << *least << " to " << *most;
  expect_all_results();
}

TEST_F(LoadTest, NothingIsLostWhenTheCoordinatorIsKilledUnderLoad) {
  submit({.jobs = 4, .users = 2, .scenes = 2, .units = long_form() ? 10'000u : 900u});
  const auto workers =
      fleet({.workers = long_form() ? 1000u : 150u, .threads_per_worker = 2, .unit_time = milliseconds(50)});
  ASSERT_TRUE(wait_for([&] { return progress_.done() > progress_.wanted() / 4; }));
  farm_.kill_and_restart();
  ASSERT_TRUE(wait_for([&] { return progress_.all_done(); }))
      << progress_.done() << " of " << progress_.wanted();
  EXPECT_EQ(workers->tally().refused, 0u);
  expect_all_results();
}

// Prints how long it took: seconds, for a million (the long form).
TEST(Restart, KnowsWhatIsDone) {
  const std::uint32_t units = long_form() ? 1'000'000 : 40'000;
  std::string job;
  FarmUnderLoad farm{TESSERA_SERVER_PROGRAM,
                     {"--log-level", "warning"},
                     [&](const std::filesystem::path& data) { job = write_journal(data, units); }};
  const milliseconds took = farm.kill_and_restart();
  const ProcessUse use = farm.use();
  std::printf("ready %.2f s after the start with %u results in the journal; %.2f s of CPU, %.0f MiB\n",
              static_cast<double>(took.count()) / 1e3, units, static_cast<double>(use.cpu.count()) / 1e3,
              static_cast<double>(use.peak_resident_bytes) / (1 << 20));
  const absl::StatusOr<v1::GetJobResponse> answer = farm.client().job(job, {});
  ASSERT_TRUE(answer.ok()) << answer.status();
  EXPECT_EQ(answer->status().units_done(), units - 1);
  EXPECT_EQ(answer->status().stats().samples(), stub_stats(milliseconds(1)).samples() * (units - 1));
}

}  // namespace
}  // namespace tessera::load
