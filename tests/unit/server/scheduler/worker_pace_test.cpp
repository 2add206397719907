#include "scheduler/worker_pace.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace tessera::server {
namespace {

/// Workers that return results for one job in turn.
class Crew {
 public:
  explicit Crew(std::size_t workers) : paces_(workers) {
    for (std::size_t i = 0; i < workers; ++i) paces_[i].worker = i + 1;
  }

  void result(std::size_t worker, double cost) {
    job_.compare(paces_[worker], usual_, std::log(cost));
    std::vector<const WorkerPace*> all;
    for (const WorkerPace& pace : paces_) all.push_back(&pace);
    usual_ = usual_pace(all);
  }
  double slowness(std::size_t worker) const { return slowness_of(paces_[worker], usual_); }

 private:
  JobPace job_{1};
  UsualPace usual_;
  std::vector<WorkerPace> paces_;
};

TEST(WorkerPace, AWorkerAloneIsTheUsualOneWhateverItsUnitsCost) {
  Crew crew(1);
  for (int i = 0; i < 1000; ++i) {
    crew.result(0, i < 500 ? 1 : 1000);
    EXPECT_EQ(crew.slowness(0), 1);
  }
}

TEST(WorkerPace, CostsThatGrowForEverybodyAreNotAPace) {
  Crew crew(3);
  // Ten times more every 100 results, of each worker alike.
  for (int i = 0; i < 600; ++i) {
    crew.result(i % 3, std::pow(10.0, i / 100.0));
    for (int worker = 0; worker < 3; ++worker) EXPECT_EQ(crew.slowness(worker), 1) << i;
  }
}

TEST(WorkerPace, OneUnitOfAHundredTimesTheCostProvesNothing) {
  Crew crew(4);
  for (int i = 0; i < 400; ++i) crew.result(i % 4, i == 200 ? 100 : 1);
  for (int worker = 0; worker < 4; ++worker) EXPECT_EQ(crew.slowness(worker), 1);
}

TEST(WorkerPace, WhatIsAlwaysTenTimesAsLongIsAPace) {
  Crew crew(4);
  // Three fast workers return ten results each while the slow one returns one.
  for (int i = 0; i < 1240; ++i) crew.result(i % 31 == 0 ? 0 : 1 + i % 3, i % 31 == 0 ? 10 : 1);
  // Costs of 40 results are assumed to have a variance of 1.3, which leaves a doubt of 4.5^2 * 1.3 / 40 at
  // most: 10 less a factor of exp(0.66 / 2.3), and as much again for what the others' are assumed to have.
  EXPECT_GE(crew.slowness(0), 5.6);
  EXPECT_LE(crew.slowness(0), 10.1);
  for (int worker = 1; worker < 4; ++worker) EXPECT_EQ(crew.slowness(worker), 1);
}

TEST(WorkerPace, AWorkerFourTimesAsFastIsKnownAsFast) {
  Crew crew(4);
  for (int i = 0; i < 1400; ++i) crew.result(i % 7 < 4 ? 0 : i % 7 - 3, i % 7 < 4 ? 0.25 : 1);
  EXPECT_NEAR(crew.slowness(0), 0.25, 0.05);
}

TEST(WorkerPace, UnevenCostsOfEqualWorkersShowNoPace) {
  std::mt19937_64 random(1);
  std::lognormal_distribution<double> cost(0, 1.15);  // two decades
  Crew crew(6);
  for (int i = 0; i < 20'000; ++i) {
    crew.result(random() % 6, cost(random));
    for (int worker = 0; worker < 6; ++worker) {
      // Beyond 4.5 standard deviations seven times in a million, and then by little.
      EXPECT_NEAR(crew.slowness(worker), 1, 0.2) << i;
    }
  }
}

TEST(WorkerPace, SlownessThatIsProvenIsKeptByAWorkerThatIsAlone) {
  Crew crew(2);
  for (int i = 0; i < 1000; ++i) crew.result(i % 11 == 0 ? 0 : 1, i % 11 == 0 ? 10 : 1);
  const double known = crew.slowness(0);
  EXPECT_GT(known, 5);
  for (int i = 0; i < 100; ++i) crew.result(0, 10);
  EXPECT_NEAR(crew.slowness(0), known, 0.2 * known);
}

}  // namespace
}  // namespace tessera::server
