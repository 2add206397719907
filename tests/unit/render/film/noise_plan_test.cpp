// Sample counts out of pilots.
#include "render/film/noise_plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include "wire/limits.h"

namespace tessera::render::noise_plan_test {
namespace {

/// A pilot of 16x16 blocks: error of a block's samples, and how it is seen.
template <class Error>
Pilot pilot_of(Error error) {
  Pilot pilot{{0, 0, 16, 16}, {}};
  for (std::uint32_t i = 0; i < 256; ++i) pilot.values.push_back({error(i % 16, i / 16), 4});
  return pilot;
}

/// The deviation that a pilot of `degrees` of freedom a half sees.
std::array<float, 2> seen(double error, std::mt19937& random, double degrees = 12) {
  std::gamma_distribution<double> chi2(degrees / 2, 2 / degrees);
  return {static_cast<float>(error * chi2(random)), static_cast<float>(error * chi2(random))};
}

double root_error(const SampleCounts& plan, const Pilot& pilot) {
  double sum = 0;
  for (std::size_t i = 0; i < plan.counts.size(); ++i)
    sum += 0.5 * double{pilot.values[i].error[0] + pilot.values[i].error[1]} / plan.counts[i];
  return std::sqrt(sum / static_cast<double>(plan.counts.size()));
}

TEST(NoisePlan, GoodCountsArePowersOfTwoAndHalfWay) {
  std::set<std::uint32_t> counts;
  for (double samples = 0; samples < 100; samples += 0.25) {
    const std::uint32_t count = good_count(samples);
    counts.insert(count);
    // Next to it, in ratio: steps are of 2, 4 / 3 and 3 / 2.
    if (samples < 1) continue;
    EXPECT_LE(std::abs(std::log(samples / count)), 0.5 * std::log(2.0) + 1e-12) << samples;
  }
  EXPECT_EQ(counts, (std::set<std::uint32_t>{1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96}));
  EXPECT_EQ(good_count(INFINITY), std::uint32_t{1} << 24);
  EXPECT_EQ(good_count(NAN), 1u);
}

TEST(NoisePlan, EvenNoiseTakesTheSameEverywhere) {
  int uneven = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    const Pilot pilot = pilot_of([&](auto, auto) { return seen(0.2, random); });
    const SampleCounts plan = plan_samples({0.05, 4096}, pilot);
    const bool even = std::set(plan.counts.begin(), plan.counts.end()).size() == 1;
    EXPECT_EQ(plan.even, even);
    uneven += !even;
  }
  EXPECT_EQ(uneven, 0);
}

TEST(NoisePlan, QuietHalvesTakeFewerAndThePictureHasTheErrorAskedFor) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    const Pilot pilot = pilot_of([&](std::uint32_t x, auto) { return seen(x < 8 ? 0.001 : 0.4, random); });
    const SampleCounts plan = plan_samples({0.05, 4096}, pilot);
    double quiet = 0, noisy = 0;
    for (std::uint32_t y = 0; y < 16; ++y) {
      for (std::uint32_t x = 0; x < 7; ++x) quiet += plan.at(8 * x, 8 * y);
      for (std::uint32_t x = 9; x < 16; ++x) noisy += plan.at(8 * x, 8 * y);
    }
    EXPECT_LT(quiet, noisy / 4);
    // Equal counts would be 80 each; half a step of counts is 1.22.
    EXPECT_LE(root_error(plan, pilot), 0.05 * 1.001);
    EXPECT_GE(root_error(plan, pilot), 0.05 / 1.3);
  }
}

TEST(NoisePlan, KeepsToTheCapAndToTheLeast) {
  std::mt19937 random(1);
  const Pilot pilot = pilot_of([&](std::uint32_t x, auto) { return seen(x < 8 ? 0 : 0.4, random); });
  for (const std::uint32_t cap : {2u, 16u, 17u, 100u}) {
    const SampleCounts plan = plan_samples({1e-4, cap}, pilot);
    for (const std::uint32_t count : plan.counts) {
      EXPECT_LE(count, cap);
      EXPECT_GE(count, std::min(cap, wire::kLeastNoiseSamples));
    }
    EXPECT_EQ(plan.at(127, 127), cap) << "an error that is never met";
  }
}

TEST(NoisePlan, WhateverThePilotSawIsAnAnswer) {
  for (const float error : {0.0f, 1e-30f, 1e30f}) {
    const SampleCounts plan = plan_samples({0.02, 256}, pilot_of([&](auto, auto) {
                                             return std::array{error, error};
                                           }));
    for (const std::uint32_t count : plan.counts)
      EXPECT_EQ(count, error < 1 ? wire::kLeastNoiseSamples : 256u) << error;
    EXPECT_TRUE(plan.even);
  }
  // One half has seen nothing at all, and the other a single block.
  const SampleCounts plan = plan_samples({0.02, 256}, pilot_of([&](std::uint32_t x, std::uint32_t y) {
                                           return std::array{x + y == 0 ? 1e30f : 0.0f, 0.0f};
                                         }));
  EXPECT_EQ(plan.at(0, 0), 256u);
}

TEST(NoisePlan, WhatIsBeyondTheBlocksTakesAsManyAsTheNearest) {
  const SampleCounts counts{{2, 3, 4, 5}, {1, 2, 3, 4}};
  EXPECT_EQ(counts.at(16, 24), 1u);
  EXPECT_EQ(counts.at(31, 39), 4u);
  EXPECT_EQ(counts.at(0, 100), 3u);
  EXPECT_EQ(counts.at(static_cast<std::uint32_t>(-5), static_cast<std::uint32_t>(-1)), 1u);
  EXPECT_EQ(counts.at(1000, static_cast<std::uint32_t>(-1)), 2u);
}

TEST(NoisePlan, ScatteredSamplesLeaveTheIntegralOfTheFiltersSquare) {
  FilterSpec spec;
  EXPECT_NEAR(scattered_noise_share(PixelFilterRecord::build(spec)), 1, 1e-6);
  spec.kind = FilterKind::kTriangle;
  spec.radius_x = 1, spec.radius_y = 2;
  EXPECT_NEAR(scattered_noise_share(PixelFilterRecord::build(spec)), 2.0 / 3 / 3, 1e-5);
  spec.kind = FilterKind::kGaussian;
  spec.radius_x = spec.radius_y = 3, spec.sigma = 0.5f;
  // 1 / (4 pi sigma^2), but for what is cut off.
  EXPECT_NEAR(scattered_noise_share(PixelFilterRecord::build(spec)), 0.3183, 2e-3);
}

}  // namespace
}  // namespace tessera::render::noise_plan_test
