// The survey of a job's cost, against populations whose sums are known.
#include "pilot/estimate.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

namespace tessera::client {
namespace {

/// Costs between one and three.
std::vector<double> costs_of(std::size_t parts) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> cost(1, 3);
  std::vector<double> costs(parts);
  for (double& one : costs) one = cost(random);
  return costs;
}

absl::StatusOr<JobEstimate> survey_of(const std::vector<double>& costs, SurveyPlan plan) {
  plan.parts = costs.size();
  return survey(
      plan,
      [&](std::size_t part) -> absl::StatusOr<PartCost> {
        return PartCost{
            .cpu_seconds = costs[part], .samples = 2 * costs[part], .capped = 1, .spent = costs[part] / 4};
      },
      {});
}

TEST(Survey, OfAllPartsIsExact) {
  const std::vector<double> costs = costs_of(20);
  const auto estimate = survey_of(costs, {});
  ASSERT_TRUE(estimate.ok());
  const double sum = std::accumulate(costs.begin(), costs.end(), 0.0);
  EXPECT_EQ(estimate->parts, 20u);
  EXPECT_NEAR(estimate->cpu_seconds, sum, 1e-9);
  EXPECT_NEAR(estimate->samples, 2 * sum, 1e-9);
  EXPECT_NEAR(estimate->capped, 20, 1e-9);
  EXPECT_EQ(estimate->cpu_error, 0);
  // The first part was rendered twice.
  EXPECT_GT(estimate->survey_seconds, sum / 4);
  EXPECT_LT(estimate->survey_seconds, sum / 2);
}

TEST(Survey, OfSomeSamplesOfAllPartsIsNotExact) {
  const auto estimate = survey_of(costs_of(20), {.whole = false});
  ASSERT_TRUE(estimate.ok());
  EXPECT_EQ(estimate->parts, 20u);
  EXPECT_GT(estimate->cpu_error, 0);
}

TEST(Survey, IsUnbiasedAndKnowsItsError) {
  // 24 of 100 parts. Estimates over errors have a variance of 1 but for what 23 degrees of freedom add,
  // 23 / 21; the sum of 400 squares has a standard deviation of about sqrt(2 * 400) = 28 times that.
  constexpr int kSurveys = 400;
  const std::vector<double> costs = costs_of(100);
  const double sum = std::accumulate(costs.begin(), costs.end(), 0.0);
  double mean = 0, squares = 0;
  for (int i = 0; i < kSurveys; ++i) {
    const auto estimate =
        survey_of(costs, {.wanted_error = 1e-9, .cpu_seconds = 0, .seed = static_cast<std::uint64_t>(i)});
    ASSERT_TRUE(estimate.ok());
    EXPECT_EQ(estimate->parts, kFirstParts);
    const double z = (estimate->cpu_seconds - sum) / estimate->cpu_error;
    mean += z / kSurveys;
    squares += z * z;
  }
  EXPECT_LT(std::abs(mean), 4 / std::sqrt(kSurveys));
  EXPECT_NEAR(squares, kSurveys * 23.0 / 21, 4 * 31);
}

TEST(Survey, EndsWhenTheErrorIsSmallEnough) {
  const std::vector<double> costs = costs_of(10'000);
  const auto rough = survey_of(costs, {.wanted_error = 0.05, .cpu_seconds = 1e9});
  const auto fine = survey_of(costs, {.wanted_error = 0.01, .cpu_seconds = 1e9, .threads = 3});
  ASSERT_TRUE(rough.ok() && fine.ok());
  EXPECT_LE(rough->cpu_error, 0.05 * rough->cpu_seconds);
  EXPECT_LE(fine->cpu_error, 0.01 * fine->cpu_seconds);
  EXPECT_LT(rough->parts, fine->parts);
  EXPECT_LT(fine->parts, costs.size());
}

TEST(Survey, DoesNotDependOnThreads) {
  const std::vector<double> costs = costs_of(500);
  const auto one = survey_of(costs, {.wanted_error = 0.02, .cpu_seconds = 1e9, .threads = 1});
  const auto four = survey_of(costs, {.wanted_error = 0.02, .cpu_seconds = 1e9, .threads = 4});
  ASSERT_TRUE(one.ok() && four.ok());
  EXPECT_EQ(one->cpu_seconds, four->cpu_seconds);
  EXPECT_EQ(one->parts, four->parts);
}

TEST(Survey, EndsWithTheFirstError) {
  std::atomic<int> calls = 0;
  const auto estimate = survey({.parts = 1000, .threads = 2},
                               [&](std::size_t) -> absl::StatusOr<PartCost> {
                                 ++calls;
                                 return absl::InternalError("lost");
                               },
                               {});
  EXPECT_EQ(estimate.status().message(), "lost");
  EXPECT_LE(calls, 2);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_TRUE(absl::IsCancelled(survey(
                                    {.parts = 9}, [](std::size_t) { return PartCost{}; }, stop.get_token())
                                    .status()));
}

}  // namespace
}  // namespace tessera::client
