// Every algorithm that there is, on a farm whose members die: the bits of one process.
// TESSERA_KILLS=N in the environment kills that often, TESSERA_SEED=N otherwise than by default.
#include <gtest/gtest.h>

#include <cctype>
#include <cstdio>
#include <random>
#include <string>

#include "integration/farm_under_test.h"
#include "support/long_form.h"
#include "wire/algorithm.h"

namespace tessera::integration {
namespace {

/// 64 tiles or `spp` passes of some milliseconds each, and the algorithm's phases before; with two layers
/// where it has such: more would make units of passes longer.
Arguments job_by(const std::string& algorithm, std::uint32_t spp) {
  const bool layers = wire::find_algorithm(algorithm)->layers != wire::LayerStates::kNone;
  return {"scenes/cornell-box/scene.pbrt",
          "--integrator",
          algorithm,
          "--resolution",
          "128x128",
          "--spp",
          std::to_string(spp),
          "--tile",
          "16",
          "--aov",
          layers ? "bounce0..bounce1" : "samples",
          "--quiet"};
}

/// The kills of a job are spread over its units, the first within its first phase.
constexpr std::uint32_t kSpread = 4;
/// A job that ends before anybody is killed says nothing: the next one is twice as long.
constexpr std::uint32_t kFirstSpp = 64, kLastSpp = 4096;

class OnAFarm : public testing::TestWithParam<std::string> {};

TEST_P(OnAFarm, KillsChangeNoBit) {
  const auto kills = static_cast<std::uint32_t>(test::how_often("TESSERA_KILLS", 2, 20));
  std::mt19937_64 random{test::how_often("TESSERA_SEED", 1, 2)};
  FarmUnderTest farm;
  // Both are of one host: as many deaths in a minute as here would otherwise speak against the units.
  for (int i = 0; i < 2; ++i) farm.add_worker(1, "host");
  std::uint32_t done = 0, jobs = 0, spp = kFirstSpp;
  while (done < kills && spp <= kLastSpp && !HasFailure()) {
    const Arguments job = job_by(GetParam(), spp);
    const std::string id = farm.submit_detached(job + Arguments{"--fresh"});
    ++jobs;
    const std::uint32_t before = done;
    for (std::uint32_t share = 0; share < kSpread && done < kills; ++share) {
      const v1::JobStatus status = farm.watch_until(id, [&](const v1::JobStatus& s) {
        return s.units_leased() > 0 &&
               (s.units_done() + s.units_leased()) * kSpread >= share * s.units_total();
      });
      if (client::has_ended(status.state())) break;
      farm.kill_somebody(random);
      ++done;
    }
    if (done == before) spp *= 2;
    const v1::JobStatus end = farm.watch_to_the_end(id);
    ASSERT_EQ(end.state(), v1::DONE) << end.error();
    EXPECT_EQ(farm.fetch_hash(id), expected_hash(job));
  }
  EXPECT_EQ(done, kills) << "jobs end before anybody is killed";
  std::printf("%u kills in %u jobs\n", done, jobs);
}

std::vector<std::string> all_algorithms() {
  std::vector<std::string> names;
  for (const wire::AlgorithmTraits& algorithm : wire::algorithms()) names.emplace_back(algorithm.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Algorithms, OnAFarm, testing::ValuesIn(all_algorithms()),
                         [](const testing::TestParamInfo<std::string>& algorithm) {
                           std::string name = algorithm.param;
                           for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
                           return name;
                         });

}  // namespace
}  // namespace tessera::integration
