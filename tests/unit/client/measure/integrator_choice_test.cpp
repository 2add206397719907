// Each meter goes on with the integrator that needs the least rays, on readings that are made up.
#include "measure/integrator_choice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace tessera::client {
namespace {

using Draw = std::function<double(std::mt19937_64&)>;

Draw spread(double mean, double deviation) {
  return [=](std::mt19937_64& random) { return std::normal_distribution<double>(mean, deviation)(random); };
}

/// Meters of one point each, whose readings are drawn from a distribution of each integrator.
struct MadeUpMeters {
  std::map<std::string, std::vector<Draw>> draws;
  std::map<std::string, std::uint64_t> rays_per_pixel{};
  std::map<std::string, std::vector<std::uint64_t>> pixels{};  // so far, by meter
  std::set<std::string> refused{};
  std::vector<std::uint64_t> seeds{};

  MeasurePlan plan() const {
    MeasurePlan plan;
    plan.cells = draws.begin()->second.size();
    for (std::size_t i = 0; i < plan.cells; ++i) {
      PlannedProbe& probe = plan.probes.emplace_back();
      probe.first_cell = i;
      probe.probe.set_kind(v1::Probe::PLANE);
      probe.probe.mutable_point()->set_x(static_cast<double>(i));
      plan.meters.emplace_back().readings.emplace_back().terms = {{i, 1.0}};
    }
    return plan;
  }

  absl::StatusOr<ProbePicture> render(const ProbeJob& job) {
    seeds.push_back(job.seed);
    if (refused.contains(job.integrator)) return absl::InvalidArgumentError("not for this scene");
    std::vector<std::uint64_t>& counts = pixels[job.integrator];
    counts.resize(draws.begin()->second.size());
    std::mt19937_64 random(job.seed);
    ProbePicture picture;
    for (const v1::Probe& probe : job.camera.probes()) {
      const auto meter = static_cast<std::size_t>(probe.point().x());
      counts[meter] += probe.pixels_of_cells(0);
      for (std::uint32_t i = 0; i < probe.pixels_of_cells(0); ++i)
        picture.pixels.push_back({draws.at(job.integrator)[meter](random)});
    }
    const std::uint64_t rays =
        rays_per_pixel.contains(job.integrator) ? rays_per_pixel[job.integrator] : 1000;
    picture.rays = rays * picture.pixels.size();
    picture.pixels.resize(std::size_t{job.width} * job.height);
    return picture;
  }

  SampledCells sample(const MeasurePlan& plan, SamplingOptions options) {
    auto sampled = sample_cells(plan, options, [this](const ProbeJob& job) { return render(job); });
    EXPECT_TRUE(sampled.ok()) << sampled.status();
    return sampled.ok() ? *std::move(sampled) : SampledCells{};
  }
};

const std::vector<std::string> kTwo = {"path", "bdpt"};

TEST(IntegratorChoice, EachMeterHasTheOneOfLeastVarianceTimesRays) {
  // The first meter is four times as noisy by paths, the second by both ends.
  MadeUpMeters meters{{{"path", {spread(10, 4), spread(10, 1)}}, {"bdpt", {spread(10, 1), spread(10, 4)}}}};
  const MeasurePlan plan = meters.plan();
  for (const std::uint64_t seed : {1u, 1001u, 2001u, 3001u}) {
    meters.pixels.clear(), meters.seeds.clear();
    const SampledCells sampled = meters.sample(plan, {.error = 0.005, .seed = seed, .integrators = kTwo});
    ASSERT_EQ(sampled.integrator_of_meter, (std::vector<std::size_t>{1, 0}));
    // Readings for the choice are in no mean: 16 pixels by each.
    EXPECT_EQ(sampled.cells[0].pixels(), meters.pixels["bdpt"][0] - 16);
    EXPECT_EQ(meters.pixels["path"][0], 16u);
    EXPECT_EQ(meters.pixels["bdpt"][1], 16u);
    EXPECT_LE(relative_error(plan.meters[0].readings[0], sampled), 0.005);
    EXPECT_EQ(std::set<std::uint64_t>(meters.seeds.begin(), meters.seeds.end()).size(), meters.seeds.size());
  }
}

TEST(IntegratorChoice, RaysCount) {
  // Half of the deviation does not pay ten times the rays.
  MadeUpMeters meters{{{"path", {spread(10, 4)}}, {"bdpt", {spread(10, 2)}}},
                      {{"path", 100}, {"bdpt", 1000}}};
  const MeasurePlan plan = meters.plan();
  for (const std::uint64_t seed : {1u, 1001u, 2001u, 3001u}) {
    const SampledCells sampled = meters.sample(plan, {.error = 0.005, .seed = seed, .integrators = kTwo});
    EXPECT_EQ(sampled.integrator_of_meter, std::vector<std::size_t>{0});
  }
}

TEST(IntegratorChoice, IsNotMadeWhereFewSamplesFollow) {
  MadeUpMeters meters{{{"path", {spread(10, 0.4)}}, {"bdpt", {spread(10, 0.01)}}}};
  const MeasurePlan plan = meters.plan();
  // Sixteen pixels are within 2 %: less than sixteen times as many are needed.
  const SampledCells sure = meters.sample(plan, {.error = 0.01, .integrators = kTwo});
  EXPECT_EQ(sure.integrator_of_meter, std::vector<std::size_t>{0});
  EXPECT_FALSE(meters.pixels.contains("bdpt"));
  MadeUpMeters usual{{{"", {spread(10, 0.4)}}}};
  EXPECT_TRUE(usual.sample(usual.plan(), {.samples = 4096, .integrators = kTwo}).integrator_of_meter.empty());
}

TEST(IntegratorChoice, TellsSamplesAsTheyWereAskedFor) {
  MadeUpMeters meters{{{"path", {spread(10, 4)}}, {"bdpt", {spread(10, 1)}}}};
  const SampledCells sampled = meters.sample(meters.plan(), {.samples = 64 * 1024, .integrators = kTwo});
  EXPECT_EQ(sampled.integrator_of_meter, std::vector<std::size_t>{1});
  EXPECT_EQ(sampled.cells[0].pixels(), 1024u);
  EXPECT_EQ(meters.pixels["bdpt"][0], 1040u);
}

TEST(IntegratorChoice, LeavesOutWhatFindsLessLightOrRestsOnOnePixel) {
  // One never sees a part of the light; of another, nearly all comes by rare paths.
  const Draw rare = [](std::mt19937_64& random) {
    return std::bernoulli_distribution(1.0 / 16)(random) ? 170 : 0.01;
  };
  MadeUpMeters meters{{{"path", {spread(10, 4), spread(10, 4)}},
                       {"bdpt", {spread(1, 0.01), rare}},
                       {"light", {spread(0, 0), spread(1, 0.1)}}}};
  const MeasurePlan plan = meters.plan();
  for (const std::uint64_t seed : {1u, 1001u, 2001u, 3001u}) {
    const SampledCells sampled =
        meters.sample(plan, {.error = 0.01, .seed = seed, .integrators = {"path", "bdpt", "light"}});
    EXPECT_EQ(sampled.integrator_of_meter, (std::vector<std::size_t>{0, 0})) << seed;
  }
  // Light that only one finds, it has to find.
  MadeUpMeters caustic{{{"path", {spread(1, 0.3)}}, {"bdpt", {spread(10, 4)}}}};
  EXPECT_EQ(caustic.sample(caustic.plan(), {.error = 0.01, .integrators = kTwo}).integrator_of_meter,
            std::vector<std::size_t>{1});
}

TEST(IntegratorChoice, LightTracingReadsNoRays) {
  v1::Probe probe;
  probe.set_kind(v1::Probe::EXITANCE);
  EXPECT_FALSE(can_read("light", probe));
  EXPECT_TRUE(can_read("bdpt", probe));
  probe.set_kind(v1::Probe::CONE);
  EXPECT_FALSE(can_read("light", probe));
  probe.set_field_degrees(2);
  EXPECT_TRUE(can_read("light", probe));
  EXPECT_FALSE(can_read("mlt", probe));
  // Meters of rays are not asked of it.
  MadeUpMeters meters{{{"path", {spread(10, 4)}}, {"light", {spread(10, 1)}}}};
  MeasurePlan plan = meters.plan();
  plan.probes[0].probe.set_kind(v1::Probe::EXITANCE);
  const SampledCells sampled = meters.sample(plan, {.error = 0.01, .integrators = {"path", "light"}});
  EXPECT_EQ(sampled.integrator_of_meter, std::vector<std::size_t>{0});
  EXPECT_FALSE(meters.pixels.contains("light"));
}

TEST(IntegratorChoice, OneThatIsRefusedIsNotChosen) {
  MadeUpMeters meters{{{"path", {spread(10, 4)}}, {"bdpt", {spread(10, 1)}}}};
  meters.refused = {"bdpt"};
  const SampledCells sampled = meters.sample(meters.plan(), {.error = 0.01, .integrators = kTwo});
  EXPECT_EQ(sampled.integrator_of_meter, std::vector<std::size_t>{0});
}

}  // namespace
}  // namespace tessera::client
