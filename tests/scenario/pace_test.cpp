// How long a job takes when workers differ, and what it costs in work done twice: the scheduler with workers
// that do nothing but take their time, exactly. And what is known of workers that differ, when units differ
// too.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "scenario/scenario_runner.h"
#include "scenario/steady_farm.h"

namespace tessera::server {
namespace {

struct Pace {
  double makespan_seconds = 0;
  double duplicated = 0;  // share of all finished or abandoned work
};

/// `slowness[i]` is how much longer worker i needs for a unit than `unit`; one thread each.
Pace run_job(const std::vector<double>& slowness, std::uint32_t units, Time unit) {
  constexpr Time kStep{100};
  struct Worker {
    std::vector<v1::LeaseToken> held;  // the first one is being rendered
    Time begun{};
  };
  Scheduler scheduler({.audit_one_in = 0});
  EXPECT_TRUE(scheduler
                  .add_job({.id = "a",
                            .plan = row_of_tiles(units, 1),
                            .scene_digest = "s",
                            .isa = "avx2",
                            .user = "",
                            .required_tags = {}})
                  .ok());
  std::vector<Worker> workers(slowness.size());
  const auto name = [](std::size_t i) { return absl::StrCat("w", i); };
  for (std::size_t i = 0; i < workers.size(); ++i) {
    EXPECT_TRUE(scheduler
                    .register_worker({.id = name(i),
                                      .name = name(i),
                                      .build = "",
                                      .isa = "avx2",
                                      .supported_isas = {"avx2"},
                                      .threads = 1,
                                      .host = name(i),
                                      .tags = {}},
                                     Time{0})
                    .ok());
  }
  Time wasted{0}, useful{0};
  for (Time now{0};; now += kStep) {
    if (scheduler.job("a")->state == v1::DONE || now > 4000 * unit) {
      return {
          .makespan_seconds = static_cast<double>(now.count()) / 1000,
          .duplicated = static_cast<double>(wasted.count()) / static_cast<double>((useful + wasted).count())};
    }
    for (std::size_t i = 0; i < workers.size(); ++i) {
      Worker& worker = workers[i];
      const auto needs = Time(static_cast<std::int64_t>(static_cast<double>(unit.count()) * slowness[i]));
      // Revoked units are dropped at once; the time spent on them was spent in vain.
      const auto beat = scheduler.heartbeat(name(i), worker.held, now);
      for (const v1::LeaseToken& revoked : beat->revoked) {
        if (worker.held.front().attempt() == revoked.attempt()) {
          wasted += Time(
              static_cast<std::int64_t>(static_cast<double>((now - worker.begun).count()) / slowness[i]));
          worker.begun = now;
        }
        std::erase_if(worker.held,
                      [&](const v1::LeaseToken& held) { return held.attempt() == revoked.attempt(); });
      }
      if (!worker.held.empty() && now - worker.begun >= needs) {
        EXPECT_TRUE(
            scheduler.complete(name(i), worker.held.front(), {.fingerprint = 1, .cost = needs}, now).ok());
        worker.held.erase(worker.held.begin());
        worker.begun = now;
        useful += unit;
      }
      if (worker.held.size() > 1) continue;
      const auto leases = scheduler.lease({.worker = name(i), .max_units = 2, .loaded_scenes = {}}, now);
      for (const v1::Lease& lease : leases->leases) {
        if (worker.held.empty()) worker.begun = now;
        worker.held.push_back(lease.token());
      }
    }
  }
}

TEST(Pace, OneWorkerTenTimesSlowerCostsLittle) {
  std::vector<double> slowness(20, 1.0);
  slowness[0] = 10;
  constexpr std::uint32_t kUnits = 1000;
  const Pace pace = run_job(slowness, kUnits, Time{10'000});
  // The sum of all speeds, with nothing lost at the end.
  const double ideal = kUnits * 10.0 / 19.1;
  std::printf("makespan %.1f s, %.3f of ideal; %.2f %% of the work done twice\n", pace.makespan_seconds,
              pace.makespan_seconds / ideal, 100 * pace.duplicated);
  EXPECT_LE(pace.makespan_seconds, 1.15 * ideal);
  EXPECT_LE(pace.duplicated, 0.02);
}

TEST(Pace, EqualWorkersDoNothingTwice) {
  const Pace pace = run_job(std::vector<double>(20, 1.0), 400, Time{10'000});
  // Twenty rounds, and a step of the clock between each two.
  EXPECT_LE(pace.makespan_seconds, 200 * 1.03);
  EXPECT_EQ(pace.duplicated, 0.0);
}

/// Six machines of which the first one is as given, after so many units that differ by two decades in cost;
/// workers say how many rays there were, and a ray's cost differs by a third.
std::unique_ptr<const SteadyFarm> farm_with(SteadyFarmOptions::Machine first, std::uint32_t units) {
  std::vector<SteadyFarmOptions::Machine> machines(6);
  machines[0] = first;
  auto farm =
      std::make_unique<SteadyFarm>(SteadyFarmOptions{.machines = machines,
                                                     .jobs = {{.user = "ann", .scene = "s", .units = units}},
                                                     .spread = 1.15,
                                                     .correlation = 0.8,
                                                     .ray_spread = 0.3});
  farm->run();
  return farm;
}

/// Only proven paces are said, so the pace that is known lies between the usual and the true one, closer
/// to the latter: at 4.5 standard deviations of 0.1, a logarithm of 2.3 becomes 2.2. A third of a decade is
/// left for noise.
constexpr double kLeast = 5, kMost = 15;

TEST(Pace, AHostThatIsTenTimesSlowIsKnownForIt) {
  const auto farm = farm_with({.slowness = 10}, 2000);
  EXPECT_GE(farm->slowness(0), kLeast);
  EXPECT_LE(farm->slowness(0), kMost);
  for (int machine = 1; machine < 6; ++machine) EXPECT_EQ(farm->slowness(machine), 1) << machine;
}

TEST(Pace, ASlowHostThatJoinsLateIsKnownForIt) {
  const auto farm = farm_with({.slowness = 10, .joins = Time{300'000}}, 3000);
  EXPECT_GE(farm->slowness(0), kLeast);
  EXPECT_LE(farm->slowness(0), kMost);
}

TEST(Pace, AHostThatBecomesSlowIsKnownForIt) {
  const auto farm = farm_with({.changes = Time{200'000}, .then = 10}, 3000);
  EXPECT_GE(farm->slowness(0), kLeast);
  EXPECT_LE(farm->slowness(0), kMost);
}

TEST(Pace, AHostThatRecoversIsAsFastAsTheOthers) {
  const auto farm = farm_with({.slowness = 10, .changes = Time{400'000}, .then = 1}, 3000);
  EXPECT_GE(farm->slowness(0), 1 / 1.2);
  EXPECT_LE(farm->slowness(0), 1.2);
}

TEST(Pace, OfTwoHostsTheFasterIsTheUsualOne) {
  SteadyFarm farm({.machines = {{.slowness = 10}, {}},
                   .jobs = {{.user = "ann", .scene = "s", .units = 2000}},
                   .spread = 1.15,
                   .ray_spread = 0.3});
  farm.run();
  EXPECT_GE(farm.slowness(0), kLeast);
  EXPECT_EQ(farm.slowness(1), 1);
}

TEST(Pace, SlowHostsWorkAlongWithFastOnes) {
  std::vector<SteadyFarmOptions::Machine> machines(6);
  for (int machine = 0; machine < 3; ++machine) machines[machine].slowness = 10;
  SteadyFarm farm({.machines = machines,
                   .jobs = {{.user = "ann", .scene = "s", .units = 3000}},
                   .spread = 1.15,
                   .correlation = 0.8,
                   .ray_spread = 0.3});
  farm.run();
  for (int machine = 0; machine < 3; ++machine) EXPECT_GE(farm.slowness(machine), kLeast);
  // The last 3 * 20 units go to the fast ones alone: a twentieth of 20 s, of 1700 s.
  EXPECT_LE(farm.idle_while_units_wait(), 0.02);
}

}  // namespace
}  // namespace tessera::server
