// Throughput of equal machines when units differ by two decades: nobody idles, nobody is called slow, two
// machines do twice the work of one. Random farms and jobs; TESSERA_SCHEDULES=N and TESSERA_FIRST_SEED as in
// simulation_test.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "absl/strings/str_cat.h"
#include "scenario/seeds.h"
#include "scenario/steady_farm.h"

namespace tessera::server {
namespace {

// Two decades are four standard deviations: 95 % of the units.
const double kTwoDecades = std::log(100.0) / 4;

struct Worst {
  double idle = 0, slow = 1;
};

/// Checks the invariants after every eighth result.
void run_and_watch(SteadyFarm& farm, std::size_t machines, Worst& worst) {
  std::uint64_t results = 0;
  farm.run([&] {
    if (++results % 8 != 0) return false;
    for (std::size_t machine = 0; machine < machines; ++machine) {
      const double slowness = farm.slowness(machine);
      if (slowness > 0) worst.slow = std::max({worst.slow, slowness, 1 / slowness});
    }
    return false;
  });
  worst.idle = std::max(worst.idle, farm.idle_while_units_wait());
}

SteadyFarmOptions random_farm(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto pick = [&](std::uint64_t below) { return random() % below; };
  SteadyFarmOptions options{
      .seed = seed, .spread = kTwoDecades, .correlation = 0.1 * static_cast<double>(pick(10))};
  // Most workers say how many rays there were, as real ones do; the cost of a ray differs less.
  if (pick(3) > 0) options.ray_spread = 0.1 + 0.1 * static_cast<double>(pick(4));
  for (std::uint64_t machines = 1 + pick(12); machines > 0; --machines) {
    options.machines.push_back({.threads = static_cast<std::uint32_t>(1 + pick(4)),
                                .joins = Time(pick(3) == 0 ? pick(100'000) : 0)});
  }
  options.machines[0].joins = Time{0};
  for (std::uint64_t jobs = 1 + pick(4); jobs > 0; --jobs) {
    options.jobs.push_back({.user = absl::StrCat(pick(2)),
                            .scene = absl::StrCat(pick(3)),
                            .units = static_cast<std::uint32_t>(400 + pick(400)),
                            .median_ms = 300 + static_cast<double>(pick(3000)),
                            .submitted = Time(pick(200'000))});
  }
  options.jobs[0].submitted = Time{0};
  return options;
}

/// The same work in tiles that take half a minute or more, of which several units are leased as one.
SteadyFarmOptions random_farm_of_runs(std::uint64_t seed) {
  SteadyFarmOptions options = random_farm(seed);
  std::mt19937_64 random(seed);
  for (SteadyFarmOptions::Work& work : options.jobs) {
    work.ranges = 32u << random() % 4;
    work.units = (16 + static_cast<std::uint32_t>(random() % 32)) * work.ranges;
    work.median_ms *= 32.0 / work.ranges;
  }
  return options;
}

void expect_busy_and_equal(SteadyFarmOptions (*random)(std::uint64_t seed)) {
  Worst worst;
  const Seeds seeds = seeds_from_environment(/*count=*/60);
  for (std::uint64_t seed = seeds.first; seed < seeds.first + seeds.count; ++seed) {
    const SteadyFarmOptions options = random(seed);
    SteadyFarm farm(options);
    Worst here;
    run_and_watch(farm, options.machines.size(), here);
    // Threads wait for answers of 5 ms, of 10 at most, where units take 300 and more in the mean; not for
    // anything else.
    EXPECT_LE(here.idle, 0.02) << "seed " << seed;
    EXPECT_LE(here.slow, 1.2) << "seed " << seed;
    worst = {.idle = std::max(worst.idle, here.idle), .slow = std::max(worst.slow, here.slow)};
    if (testing::Test::HasFailure()) return;
  }
  std::printf("%llu farms: idle while units wait %.2f %% at most, pace of equal machines within %.2f\n",
              static_cast<unsigned long long>(seeds.count), 100 * worst.idle, worst.slow);
}

TEST(Throughput, EqualMachinesAreNeverIdleWhileUnitsWait) { expect_busy_and_equal(random_farm); }

TEST(Throughput, EqualMachinesAreNeverIdleWhileRunsWait) { expect_busy_and_equal(random_farm_of_runs); }

TEST(Throughput, ThreeJobsOneAfterTheOtherKeepSixWorkersBusy) {
  SteadyFarmOptions options{.machines = std::vector<SteadyFarmOptions::Machine>(6), .spread = kTwoDecades};
  for (int job = 0; job < 3; ++job) options.jobs.push_back({.user = "ann", .scene = "s", .units = 500});
  SteadyFarm farm(options);
  Worst worst;
  run_and_watch(farm, 6, worst);
  std::printf("idle while units wait %.2f %%, pace within %.2f\n", 100 * worst.idle, worst.slow);
  EXPECT_LE(worst.idle, 0.02);
  EXPECT_LE(worst.slow, 1.2);
}

TEST(Throughput, RunsTakeTenSecondsWhateverTheTileAndThreadsEndTogether) {
  constexpr std::uint32_t kTiles = 60, kRanges = 256, kThreads = 6;
  for (const double unit_ms : {6.0, 150.0, 4000.0}) {
    SteadyFarm farm({.machines = std::vector<SteadyFarmOptions::Machine>(kThreads),
                     .jobs = {{.user = "ann",
                               .scene = "s",
                               .units = kTiles * kRanges,
                               .ranges = kRanges,
                               .median_ms = unit_ms}},
                     .spread = kTwoDecades,
                     .correlation = 0.8});
    farm.run();
    const double seconds = static_cast<double>(farm.now().count()) / 1000, idle = farm.idle() * seconds;
    const double longest = static_cast<double>(farm.longest_lease().count()) / 1000;
    std::printf(
        "units of %.0f ms: %u results in %.0f s, the longest lease %.2f s, threads idle for %.2f s each\n",
        unit_ms, farm.results()[0], seconds, longest, idle);
    // The most expensive of 60 tiles is three standard deviations from the median. Nothing is shorter than a
    // unit.
    const double unit = unit_ms * std::exp(3 * kTwoDecades) / 1000;
    EXPECT_LE(longest, std::max(10.0, unit));
    // The last leases take 100 ms, or are one unit.
    EXPECT_LE(idle, 0.1 + unit);
    // Runs are powers of two, so 5 to 10 s; before that each tile has runs of 1, 1, 2, 4 ... 128 units.
    EXPECT_LE(farm.results()[0], kThreads * seconds / 5 + kTiles * 9);
  }
}

/// Seconds that one job of 2000 units takes.
double seconds_with(std::uint32_t machines, std::uint64_t seed) {
  SteadyFarmOptions options{.machines = std::vector<SteadyFarmOptions::Machine>(machines),
                            .jobs = {{.user = "ann", .scene = "s", .units = 2000}},
                            .seed = seed,
                            .spread = kTwoDecades,
                            .correlation = 0.8};
  SteadyFarm farm(options);
  farm.run();
  return static_cast<double>(farm.now().count()) / 1000;
}

TEST(Throughput, TwoMachinesDoTwiceTheWorkOfOne) {
  // The last units that are out end apart, by 20 s at most (a hundred times the median unit is 3.9 standard
  // deviations, once in 10,000), of 2000 s: 1.98 on average. What is asked for is 1.95.
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const double gain = seconds_with(1, seed) / seconds_with(2, seed);
    std::printf("two machines: %.3f times one\n", gain);
    EXPECT_GE(gain, 1.95) << "seed " << seed;
    EXPECT_LE(gain, 2.05) << "seed " << seed;
  }
}

}  // namespace
}  // namespace tessera::server
