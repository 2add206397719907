// How evenly equal jobs share a farm, and how long threads wait, when answers take a while; who gets how much
// of it, and when, where units are short and long.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "scenario/seeds.h"
#include "scenario/steady_farm.h"

namespace tessera::server {
namespace {

struct Shares {
  std::uint32_t least = 0, most = 0;  // units of a job that were done when the first job was
  double waited = 0;                  // part of the threads' time until then
};

/// Workers of one thread, and equal jobs of five users, each with a scene of its own; units take 5 s, by a
/// third more or less, and answers half a second.
Shares share_farm(std::size_t workers, std::size_t jobs, std::uint32_t units_of_job) {
  SteadyFarmOptions options{.spread = 0.3, .answer = Time{500}};
  options.scheduler.order = JobOrder::kFair;
  for (std::size_t worker = 0; worker < workers; ++worker) {
    options.machines.push_back({.joins = Time(worker * 2000 / workers)});
  }
  for (std::size_t job = 0; job < jobs; ++job) {
    options.jobs.push_back({.user = absl::StrCat("user ", job % 5),
                            .scene = absl::StrCat("scene ", job),
                            .units = units_of_job,
                            .median_ms = 5000});
  }
  SteadyFarm farm(std::move(options));
  farm.run([&] { return *std::max_element(farm.done().begin(), farm.done().end()) == units_of_job; });
  const auto [least, most] = std::minmax_element(farm.done().begin(), farm.done().end());
  return {.least = *least, .most = *most, .waited = farm.idle_while_units_wait()};
}

void expect_even(const Shares& shares, double least) {
  std::printf("%u to %u units of each job; threads waited for %.1f %% of their time\n", shares.least,
              shares.most, 100 * shares.waited);
  EXPECT_GE(shares.least, least * shares.most);
  EXPECT_LE(shares.waited, 0.03);
}

TEST(Shares, ManyEqualJobsAdvanceTogetherAndThreadsHardlyWait) {
  // The cost of 160 units differs by 0.31 / sqrt(160) = 2.4 %, the extremes of 50 jobs by 11 %; ten units of
  // each job are out when the first one ends, 6 %. Seeds 1 to 12 give 0.83 to 0.90.
  expect_even(share_farm(/*workers=*/500, /*jobs=*/50, /*units_of_job=*/160), 0.8);
}

TEST(Shares, FewLongJobsAdvanceTogetherAndThreadsHardlyWait) {
  expect_even(share_farm(/*workers=*/500, /*jobs=*/10, /*units_of_job=*/800), 0.97);
}

SteadyFarmOptions::Machine with_threads(std::uint32_t threads) { return {.threads = threads}; }

TEST(Shares, AFewUnitsOfAnotherUserDoNotWaitForThousandsOfShortOnes) {
  const std::vector<std::vector<SteadyFarmOptions::Machine>> farms = {{with_threads(2)},
                                                                      std::vector(3, with_threads(1))};
  for (const auto& machines : farms) {
    SteadyFarm farm(
        {.machines = machines,
         .jobs = {{.user = "ann", .scene = "s", .units = 4096, .median_ms = 100},
                  {.user = "bob", .scene = "t", .units = 4, .median_ms = 2000, .submitted = Time{10'000}}}});
    farm.run([&] { return farm.done()[1] == 4; });
    // Once 4 s of ann's work were given out over its head, bob's job has its turn: after 2 s of two threads,
    // behind a unit or two in each hand. Its four units take 4 s.
    EXPECT_LE(*farm.first_lease_after(1), Time{2500});
    EXPECT_LE(farm.now(), Time{10'000 + 8000});
  }
}

TEST(Shares, ShortUnitsAndLongOnesGetTheSame) {
  SteadyFarm farm({.machines = std::vector(3, with_threads(2)),
                   .jobs = {{.user = "ann", .scene = "s", .units = 8000, .median_ms = 100},
                            {.user = "bob", .scene = "t", .units = 200, .median_ms = 5000}},
                   .spread = 0.3});
  farm.run([&] { return farm.now() >= Time{120'000}; });
  const double anns = farm.done()[0] * 100.0, bobs = farm.done()[1] * 5000.0;
  std::printf("short units %.1f s, long ones %.1f s\n", anns / 1000, bobs / 1000);
  // Out of 360 s each, a worker's lead (4 s) and the units that it holds (two units of 5 s a thread, 6
  // threads) are 64.
  EXPECT_NEAR(anns / bobs, 1, 64.0 / 360);
}

TEST(Shares, TheFirstOfThirtyFramesIsDoneFirst) {
  SteadyFarmOptions options{.machines = std::vector(4, with_threads(2)), .spread = 0.6};
  for (int frame = 0; frame < 30; ++frame) {
    options.jobs.push_back({.user = "ann", .scene = absl::StrCat(frame), .units = 60, .median_ms = 500});
  }
  SteadyFarm farm(options);
  farm.run();
  for (std::size_t frame = 1; frame < 30; ++frame) {
    // The next one gets what the last units leave of the threads, and may overtake by one of them.
    EXPECT_GE(farm.finished(frame) + Time{5000}, farm.finished(frame - 1)) << frame;
  }
  // A thirtieth of the time, and the last of its units: e^(0.6 * 2.4) times the median of 0.5 s, twice.
  EXPECT_LE(farm.finished(0), farm.now() / 30 + Time{4500});
}

constexpr double kLongestRunMs = 10'000;

/// Users with a job each, whose units take from 10 ms to 10 s, and machines that all may do anything.
TEST(Shares, EveryUsersFirstJobHasItsTurnInBoundedTime) {
  const Seeds seeds = seeds_from_environment(/*count=*/100);
  Time longest{0};
  for (std::uint64_t seed = seeds.first; seed < seeds.first + seeds.count && !testing::Test::HasFailure();
       ++seed) {
    std::mt19937_64 random(seed);
    SteadyFarmOptions options{.seed = seed, .spread = 0.3};
    if (random() % 2 == 0) options.scheduler.order = JobOrder::kFair;
    for (std::uint64_t machines = 1 + random() % 4; machines > 0; --machines) {
      options.machines.push_back(with_threads(static_cast<std::uint32_t>(1 + random() % 2)));
    }
    const std::size_t users = 2 + random() % 6;
    double unit_ms = 0;
    for (std::size_t user = 0; user < users; ++user) {
      const double median = std::pow(10.0, 1 + static_cast<double>(random() % 1000) / 333);
      const std::uint32_t ranges = random() % 2 == 0 ? 1 : 32;
      unit_ms = std::max({unit_ms, median, ranges > 1 ? kLongestRunMs : 0});
      options.jobs.push_back({.user = absl::StrCat(user),
                              .scene = absl::StrCat(user),
                              .units = (static_cast<std::uint32_t>(60'000 / median) / ranges + 4) * ranges,
                              .ranges = ranges,
                              .median_ms = median,
                              .submitted = Time(random() % 30'000)});
    }
    SteadyFarm farm(options);
    farm.run();
    // Each user that waits may be passed over for 4 s of work, on one thread, and has a lease or two given
    // out before it; one is as long as the longest unit, e^(0.3 * 4) times its median, or run, and the first
    // ones count as 1 s before that is known.
    const Time bound(static_cast<std::int64_t>(static_cast<double>(users) * (4000 + 2 * 3.4 * unit_ms)) +
                     1000);
    for (std::size_t job = 0; job < users; ++job) {
      ASSERT_TRUE(farm.first_lease_after(job)) << "seed " << seed;
      EXPECT_LE(*farm.first_lease_after(job), bound) << "seed " << seed << ", job " << job;
      longest = std::max(longest, *farm.first_lease_after(job));
    }
  }
  std::printf("the longest that a job waited for its first unit: %.1f s\n",
              static_cast<double>(longest.count()) / 1000);
}

}  // namespace
}  // namespace tessera::server
