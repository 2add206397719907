// Rounds of sampling, on readings that are made up: which cells are asked for, and when it is enough.
#include "measure/sampling.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <set>
#include <vector>

#include "measure/ratio.h"

namespace tessera::client {
namespace {

/// A plan of points, each a probe of one cell and a figure.
MeasurePlan plan_of_points(std::size_t points) {
  MeasurePlan plan;
  PlannedMeter& meter = plan.meters.emplace_back();
  for (std::size_t i = 0; i < points; ++i) {
    plan.probes.push_back({.probe = {}, .light = ReadLight::kAll, .first_cell = i, .cells = 1});
    PlannedReading& reading = meter.readings.emplace_back();
    reading.terms = {{i, 1.0}};
  }
  plan.cells = points;
  return plan;
}

/// Renders probes whose readings are drawn from a distribution of each cell; counts the pixels of each.
struct MadeUpScene {
  std::vector<std::function<double(std::mt19937_64&)>> cells;
  std::vector<std::uint64_t> pixels = std::vector<std::uint64_t>(cells.size());
  std::vector<std::uint64_t> seeds{};
  int jobs = 0;

  RenderProbes renderer() {
    return [this](const ProbeJob& job) -> absl::StatusOr<ProbePicture> {
      ++jobs;
      seeds.push_back(job.seed);
      std::mt19937_64 random(job.seed);
      ProbePicture picture;
      std::size_t probe = 0;
      for (std::size_t cell = 0; cell < cells.size(); ++cell) {
        // Probes of a job are those whose cells have pixels, in the order of the plan.
        if (probe == static_cast<std::size_t>(job.camera.probes_size())) break;
        const v1::Probe& asked = job.camera.probes(static_cast<int>(probe));
        if (asked.point().x() != static_cast<double>(cell)) continue;
        ++probe;
        pixels[cell] += asked.pixels_of_cells(0);
        for (std::uint32_t i = 0; i < asked.pixels_of_cells(0); ++i)
          picture.pixels.push_back({cells[cell](random)});
      }
      picture.pixels.resize(std::size_t{job.width} * job.height);
      return picture;
    };
  }
};

MeasurePlan numbered(MeasurePlan plan) {
  for (std::size_t i = 0; i < plan.probes.size(); ++i)
    plan.probes[i].probe.mutable_point()->set_x(static_cast<double>(i));
  return plan;
}

double normal(std::mt19937_64& random, double mean, double deviation) {
  return std::normal_distribution<double>(mean, deviation)(random);
}

TEST(Sampling, AsksForTheCellsThatAreNotSure) {
  const MeasurePlan plan = numbered(plan_of_points(3));
  MadeUpScene scene{{[](auto&) { return 5.0; }, [](auto& r) { return normal(r, 10, 0.1); },
                     [](auto& r) { return normal(r, 10, 4); }}};
  const auto sampled = sample_cells(plan, {.error = 0.01, .seed = 11}, scene.renderer());
  ASSERT_TRUE(sampled.ok()) << sampled.status();
  EXPECT_EQ(scene.pixels[0], 16u);
  EXPECT_EQ(scene.pixels[1], 16u);
  // (1.96 x 4 / 10 / 0.01)^2 pixels.
  EXPECT_GT(scene.pixels[2], 5000u);
  EXPECT_LT(scene.pixels[2], 10000u);
  EXPECT_LE(scene.jobs, 6);
  for (const PlannedReading& reading : plan.meters[0].readings)
    EXPECT_LE(relative_error(reading, *sampled), 0.01);
  // No two jobs have the same random numbers.
  EXPECT_EQ(std::set<std::uint64_t>(scene.seeds.begin(), scene.seeds.end()).size(), scene.seeds.size());
}

TEST(Sampling, TakesTheSamplesThatAreAskedForWhereNoErrorIs) {
  const MeasurePlan plan = numbered(plan_of_points(1));
  MadeUpScene scene{{[](auto& r) { return normal(r, 1, 1); }}};
  const auto sampled = sample_cells(plan, {.samples = 10000}, scene.renderer());
  ASSERT_TRUE(sampled.ok());
  EXPECT_EQ(sampled->samples_per_pixel, 64u);
  EXPECT_EQ(scene.pixels[0], 157u);  // 10,000 / 64, rounded up
}

TEST(Sampling, DoesNotTrustASpreadThatOnePixelMakes) {
  // One pixel in eight holds nearly all of the light, on average.
  const MeasurePlan plan = numbered(plan_of_points(1));
  MadeUpScene scene{{[](std::mt19937_64& r) {
    return std::bernoulli_distribution(1.0 / 8)(r) ? normal(r, 400, 1) : normal(r, 1, 0.001);
  }}};
  const auto sampled = sample_cells(plan, {.error = 0.2, .seed = 5}, scene.renderer());
  ASSERT_TRUE(sampled.ok());
  EXPECT_FALSE(has_heavy_tail(plan.meters[0].readings[0], *sampled));
  EXPECT_NEAR(figure_of(plan.meters[0].readings[0], *sampled).value, 50.9, 2 * 0.2 * 50.9);
}

TEST(Sampling, GoesOnForAWhileWhereThereIsNoLightYet) {
  const MeasurePlan plan = numbered(plan_of_points(2));
  MadeUpScene scene{{[](auto&) { return 0.0; }, [](auto&) { return 5.0; }}};
  const auto sampled = sample_cells(plan, {.error = 0.01, .seed = 11}, scene.renderer());
  ASSERT_TRUE(sampled.ok()) << sampled.status();
  EXPECT_EQ(scene.pixels[0], 16u * 64);
  EXPECT_EQ(scene.pixels[1], 16u);
}

TEST(Sampling, DifferencesAreJudgedByWhatTheyAreOf) {
  // Two equal means: no number of samples makes their difference sure within a part of itself.
  MeasurePlan plan = numbered(plan_of_points(2));
  plan.meters[0].readings.resize(1);
  plan.meters[0].readings[0].terms = {{0, 1.0}, {1, -1.0}};
  MadeUpScene scene{{[](auto& r) { return normal(r, 10, 1); }, [](auto& r) { return normal(r, 10, 1); }}};
  const auto sampled = sample_cells(plan, {.error = 0.005, .seed = 3}, scene.renderer());
  ASSERT_TRUE(sampled.ok());
  // (1.96 x 1.41 / 20 / 0.005)^2 = 768 pixels of each.
  EXPECT_GT(scene.pixels[0], 400u);
  EXPECT_LT(scene.pixels[0], 2000u);
  EXPECT_LE(relative_error(plan.meters[0].readings[0], *sampled), 0.005);
}

TEST(Sampling, RatiosAreSampledUntilTheyAreSure) {
  // Each of two figures within an error is not enough for their quotient.
  MeasurePlan plan = numbered(plan_of_points(1));
  const MeasurePlan other = numbered(plan_of_points(2));
  plan.probes = other.probes, plan.cells = 2;
  PlannedMeter below = plan.meters[0], ratio;
  below.readings[0].terms = {{1, 1.0}};
  ratio.name = "ratio", ratio.ratio = PlannedRatio{v1::RatioMeter::QUOTIENT, 0, 1};
  plan.meters.push_back(below), plan.meters.push_back(ratio);
  MadeUpScene scene{{[](auto& r) { return normal(r, 10, 1); }, [](auto& r) { return normal(r, 20, 2); }}};
  SamplingProgress last;
  const auto sampled = sample_cells(
      plan, {.error = 0.01, .seed = 4, .progress = [&](const SamplingProgress& now) { last = now; }},
      scene.renderer());
  ASSERT_TRUE(sampled.ok());
  const Figure figure = ratio_of(figure_of(plan.meters[0].readings[0], *sampled),
                                 figure_of(plan.meters[1].readings[0], *sampled), v1::RatioMeter::QUOTIENT);
  EXPECT_LE(relative_error_of_ratio(figure, v1::RatioMeter::QUOTIENT), 0.01);
  // (1.96 x 0.1 x 1.41 / 0.01)^2 = 768 pixels of each, where the figures alone would take 384.
  EXPECT_GT(scene.pixels[0], 550u);
  EXPECT_EQ(last.worst_meter, "ratio");
  EXPECT_LE(last.worst, 0.01);
  EXPECT_EQ(last.samples, 64 * (scene.pixels[0] + scene.pixels[1]));
}

TEST(Sampling, TellsTheWorstErrorAfterEachRound) {
  MeasurePlan plan = numbered(plan_of_points(2));
  plan.meters.push_back(plan.meters[0]);
  plan.meters[0].readings.pop_back(), plan.meters[1].readings.erase(plan.meters[1].readings.begin());
  plan.meters[0].name = "sure", plan.meters[1].name = "noisy";
  MadeUpScene scene{{[](auto&) { return 5.0; }, [](auto& r) { return normal(r, 10, 4); }}};
  std::vector<SamplingProgress> told;
  const auto sampled = sample_cells(
      plan, {.error = 0.01, .seed = 2, .progress = [&](const SamplingProgress& now) { told.push_back(now); }},
      scene.renderer());
  ASSERT_TRUE(sampled.ok());
  ASSERT_GE(told.size(), 4u);
  EXPECT_EQ(told.front().rounds, 0) << "after the first job, before figures are judged";
  double before = 1e9;
  for (const SamplingProgress& now : told) {
    if (now.rounds == 0) continue;
    EXPECT_EQ(now.worst_meter, "noisy");
    EXPECT_LE(now.worst, before);
    before = now.worst;
  }
  EXPECT_LE(told.back().worst, 0.01);
}

TEST(Sampling, TrianglesAreProbesOfTheirOwn) {
  MeasurePlan plan;
  PlannedProbe& probe = plan.probes.emplace_back();
  probe.cells = 3, probe.blobs = {unit_triangle()};
  for (const double size : {1.0, 0.0, 2.0})
    probe.triangles.push_back({.corner = {size, 0, 0}, .edge_u = {size, 0, 0}, .edge_v = {0, size, 0}});
  plan.cells = 3;
  PlannedMeter& meter = plan.meters.emplace_back();
  for (const std::size_t cell : {0u, 2u}) meter.readings.emplace_back().terms = {{cell, 1.0}};
  std::vector<ProbeJob> jobs;
  const auto sampled = sample_cells(plan, {.samples = 1024}, [&](const ProbeJob& job) {
    jobs.push_back(job);
    ProbePicture picture;
    picture.pixels.resize(std::size_t{job.width} * job.height, ChannelValues{1});
    return picture;
  });
  ASSERT_TRUE(sampled.ok());
  ASSERT_EQ(jobs.size(), 1u);
  ASSERT_EQ(jobs[0].camera.probes_size(), 2) << "the one without area is left out";
  EXPECT_EQ(jobs[0].camera.probes(1).mesh().world_from_mesh().elements(0), 2);
  EXPECT_EQ(jobs[0].camera.probes(1).pixels_of_cells_size(), 1);
  ASSERT_EQ(jobs[0].blobs.size(), 1u);
  EXPECT_EQ(jobs[0].blobs[0].ref.digest(), jobs[0].camera.probes(0).mesh().mesh().digest());
  EXPECT_EQ(sampled->cells[1].pixels(), 0u);
  EXPECT_EQ(sampled->cells[2].pixels(), 16u);
}

TEST(Sampling, CellsThatTheTimeDidNotReachHaveNoValue) {
  // One pixel more than a job has.
  constexpr std::uint64_t kJobPixels = std::uint64_t{1} << 20;
  MeasurePlan plan = numbered(plan_of_points(kJobPixels / 16 + 1));
  std::vector<ReadLight> lights;
  const auto sampled =
      sample_cells(plan, {.samples = 1024, .time_is_up = [] { return true; }}, [&](const ProbeJob& job) {
        lights.push_back(job.light);
        ProbePicture picture;
        picture.pixels.resize(std::size_t{job.width} * job.height, ChannelValues{1});
        return picture;
      });
  ASSERT_TRUE(sampled.ok());
  EXPECT_TRUE(sampled->stopped);
  EXPECT_EQ(lights, std::vector{ReadLight::kAll}) << "what is left over is not read by light of another kind";
  EXPECT_TRUE(std::isnan(figure_of(plan.meters[0].readings.back(), *sampled).value));
}

TEST(Sampling, EndsWhenTheTimeIsUp) {
  const MeasurePlan plan = numbered(plan_of_points(1));
  MadeUpScene scene{{[](auto& r) { return normal(r, 1, 1); }}};
  const auto sampled =
      sample_cells(plan, {.error = 1e-6, .time_is_up = [] { return true; }}, scene.renderer());
  ASSERT_TRUE(sampled.ok());
  EXPECT_TRUE(sampled->stopped);
  EXPECT_EQ(scene.jobs, 1);
}

TEST(Sampling, ErrorsOfSumsHaveTheirDegreesOfFreedom) {
  MeasurePlan plan = numbered(plan_of_points(2));
  plan.meters[0].readings.resize(1);
  plan.meters[0].readings[0].terms = {{0, 2.0}, {1, -1.0}};
  plan.meters[0].readings[0].constant = 7;
  MadeUpScene scene{{[](auto& r) { return normal(r, 3, 1); }, [](auto& r) { return normal(r, 5, 2); }}};
  const auto sampled = sample_cells(plan, {.samples = 1 << 16}, scene.renderer());
  ASSERT_TRUE(sampled.ok());
  const Figure figure = figure_of(plan.meters[0].readings[0], *sampled);
  // 1024 pixels of each: variances 4 x 1 and 4, over 1024.
  EXPECT_NEAR(figure.value, 7 + 6 - 5, 5 * std::sqrt(8.0 / 1024));
  EXPECT_NEAR(figure.standard_error, std::sqrt(8.0 / 1024), 0.1 * std::sqrt(8.0 / 1024));
  EXPECT_NEAR(figure.degrees_of_freedom, 2 * 1023, 0.1 * 2046);
}

}  // namespace
}  // namespace tessera::client
