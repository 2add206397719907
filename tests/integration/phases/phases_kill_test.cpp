// Phases of a farm in which somebody is killed at any moment. TESSERA_KILLS=N in the environment kills that
// often, TESSERA_SEED=N otherwise than by default.
#include <gtest/gtest.h>

#include <map>
#include <random>

#include "integration/phases/phases_job.h"
#include "support/long_form.h"

namespace tessera::integration {
namespace {

TEST_F(Phases, KillsAtAnyMomentChangeNothing) {
  constexpr std::size_t kWorkers = 2;
  const auto kills = static_cast<std::uint32_t>(test::how_often("TESSERA_KILLS", 12, 60));
  std::mt19937_64 random{test::how_often("TESSERA_SEED", 1, 2)};
  FarmUnderTest farm;
  // All are of one host: as many deaths in a minute as here would otherwise speak against the units.
  for (std::size_t i = 0; i < kWorkers; ++i) farm.add_worker(1, "host");
  std::uint32_t done = 0, jobs = 0;
  std::map<bool, std::uint32_t> within;  // kills while phases were made, and after
  while (done < kills && !HasFailure()) {
    const std::string job = farm.submit_detached(kJob + Arguments{"--fresh"});
    ++jobs;
    // One within each twelfth of the job, so that some fall into each phase and between them.
    for (std::uint32_t share = 0; share < 12 && done < kills; ++share) {
      const std::uint32_t begun = share < 6 ? share * kPhaseUnits / 6 : kPhaseUnits + (share - 6) * 60;
      const v1::JobStatus status = farm.watch_until(
          job, [&](const v1::JobStatus& s) { return s.units_done() + s.units_leased() >= begun; });
      if (client::has_ended(status.state())) break;
      farm.kill_somebody(random);
      ++within[status.units_done() < kPhaseUnits];
      ++done;
    }
    const v1::JobStatus end = farm.watch_to_the_end(job);
    ASSERT_EQ(end.state(), v1::DONE) << end.error();
    EXPECT_EQ(farm.fetch_hash(job), expected_hash(kJob));
  }
  std::printf("%u kills in %u jobs, %u of them before the picture\n", done, jobs, within[true]);
  EXPECT_GT(within[true], 0u);
}

}  // namespace
}  // namespace tessera::integration
