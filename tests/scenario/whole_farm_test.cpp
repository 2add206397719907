// Whole farms on one virtual clock (whole_farm/farm_world.h), of as many seeds as TESSERA_WORLDS says, from
// TESSERA_FIRST_SEED on.
#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "scenario/seeds.h"
#include "scenario/whole_farm/farm_world.h"
#include "support/long_form.h"

namespace tessera::test {
namespace {

std::string replay_of(std::uint64_t seed) {
  return absl::StrCat("TESSERA_FIRST_SEED=", seed,
                      " TESSERA_WORLDS=1 whole_farm_test --gtest_filter=WholeFarm.EveryJobEnds*");
}

TEST(WholeFarm, EveryJobEndsWithThePixelsOfAnUndisturbedWorld) {
  const std::uint64_t count = how_often("TESSERA_WORLDS", 300, 10'000);
  const std::uint64_t first = server::number_from("TESSERA_FIRST_SEED", 0);
  FarmWorldCounts total;
  std::uint64_t digest = 0;
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    FarmWorld world(seed, replay_of(seed));
    const std::string violation = world.run();
    if (!violation.empty()) {
      ADD_FAILURE() << "seed " << seed << ": " << violation << "\nagain: " << replay_of(seed);
      break;
    }
    const FarmWorldCounts& counts = world.counts();
    digest = digest * 0x100000001b3 ^ world.digest();
    total.turns += counts.turns, total.results += counts.results, total.mishaps += counts.mishaps;
    total.coordinator_deaths += counts.coordinator_deaths, total.worker_deaths += counts.worker_deaths;
    total.drained += counts.drained, total.failed_units += counts.failed_units;
    total.cancelled += counts.cancelled, total.reopened += counts.reopened;
    total.caches += counts.caches;
    total.submitted_again += counts.submitted_again, total.phases += counts.phases, total.time += counts.time;
  }
  std::printf("%s\n", absl::StrCat(count, " worlds, ", total.time.count() / 60'000, " minutes of theirs, ",
                                   total.turns, " turns, ", total.results, " results; deaths: ",
                                   total.coordinator_deaths, " coordinators, ", total.worker_deaths,
                                   " workers; ", total.drained, " drained, ", total.mishaps,
                                   " calls that suffered, ", total.failed_units, " units that failed, ",
                                   total.cancelled, " jobs cancelled, ", total.reopened, " reopened, ",
                                   total.submitted_again, " submitted again, ", total.phases,
                                   " with phases; ", total.caches, " caches; digest ", absl::Hex(digest))
                          .c_str());
  // A world in which nothing goes wrong proves nothing.
  if (count < 300 || testing::Test::HasFailure()) return;
  EXPECT_GT(total.coordinator_deaths, count);
  EXPECT_GT(total.worker_deaths, count);
  EXPECT_GT(total.drained, count / 2);
  EXPECT_GT(total.mishaps, count);
  EXPECT_GT(total.failed_units, count / 4);
  EXPECT_GT(total.cancelled, count / 4);
  EXPECT_GT(total.phases, count / 4);
  EXPECT_GT(total.caches, count / 10);
}

TEST(WholeFarm, AllFollowsFromTheSeed) {
  const std::uint64_t count = long_form() ? 200 : 20;
  for (std::uint64_t seed = 0; seed < count; ++seed) {
    std::uint64_t digests[2];
    for (std::uint64_t& digest : digests) {
      FarmWorld world(seed, replay_of(seed));
      static_cast<void>(world.run());
      digest = world.digest();
    }
    EXPECT_EQ(digests[0], digests[1]) << "seed " << seed;
  }
}

}  // namespace
}  // namespace tessera::test
