// A real coordinator and hundreds of workers over real connections: nothing is lost, and everybody has a share. How
// fast that is says farm_load; here no time is asserted, for the machine may be busy.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <thread>

#include "load/farm_under_load.h"
#include "support/long_form.h"

namespace tessera::load {
namespace {

using std::chrono::milliseconds;
using test::long_form;

// Reached only when something hangs.
constexpr std::chrono::seconds kPatience{100};

template <typename Condition>
bool wait_for(Condition condition) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (!condition() && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(milliseconds(10));
  return condition();
}

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
        EXPECT_TRUE(seen.insert(result.unit().index()).second) << "unit " << result.unit().index() << " came twice";
        EXPECT_EQ(result.payload(), stub_result(result.unit()));
        return absl::OkStatus();
      };
      const absl::StatusOr<v1::JobStatus> status = farm_.client().watch(job, handlers, {});
      ASSERT_TRUE(status.ok()) << status.status();
      EXPECT_EQ(status->state(), v1::DONE);
      EXPECT_EQ(seen.size(), status->units_total());
    }
  }

  FarmUnderLoad farm_{TESSERA_SERVER_PROGRAM, {"--log-level", "warning"}};
  Progress progress_;
  std::vector<std::string> jobs_;
};

TEST_F(LoadTest, JobsOfSeveralUsersShareTheFarm) {
  submit({.jobs = 10, .users = 5, .scenes = 1, .units = long_form() ? 3600u : 400u});
  const auto workers = fleet({.workers = long_form() ? 2000u : 200u, .threads = 1, .unit_time = milliseconds(100)});
  ASSERT_TRUE(wait_for([&] { return progress_.all_done(); })) << progress_.done() << " of " << progress_.wanted();
  EXPECT_EQ(workers->tally().refused, 0u);
  // A worker has 3 units at most in its hands, and all jobs nearly the same number of all that are out, at any time: 60
  // of the 400. A unit takes 50 to 150 ms, so a job's rate fluctuates by less than a part in five, and what is out when
  // the first job ends counts for none.
  const std::vector<std::uint64_t> shares = progress_.shares();
  const auto [least, most] = std::minmax_element(shares.begin(), shares.end());
  EXPECT_LE(static_cast<double>(*most), 1.5 * static_cast<double>(*least)) << *least << " to " << *most;
  expect_all_results();
}

TEST_F(LoadTest, NothingIsLostWhenTheCoordinatorIsKilledUnderLoad) {
  submit({.jobs = 4, .users = 2, .scenes = 2, .units = long_form() ? 10'000u : 900u});
  const auto workers = fleet({.workers = long_form() ? 1000u : 150u, .threads = 2, .unit_time = milliseconds(50)});
  ASSERT_TRUE(wait_for([&] { return progress_.done() > progress_.wanted() / 4; }));
  farm_.kill_and_restart();
  ASSERT_TRUE(wait_for([&] { return progress_.all_done(); })) << progress_.done() << " of " << progress_.wanted();
  EXPECT_EQ(workers->tally().refused, 0u);
  expect_all_results();
}

}  // namespace
}  // namespace tessera::load
