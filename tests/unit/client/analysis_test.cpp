#include "bench/analysis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/report.h"

namespace tessera::client {
namespace {

BenchRun run_of(std::uint32_t spp, std::uint64_t seed, double cpu_seconds, double mse, double relmse) {
  BenchRun run;
  run.spp = spp;
  run.seed_offset = seed;
  run.cost.cpu_seconds = cpu_seconds;
  run.mse = mse;
  run.relmse = relmse;
  run.relmse_block = 3 * relmse;
  return run;
}

/// Errors fall as spp^slope; `factor` is what the variant's errors are multiplied by.
BenchVariantResult variant_of(const std::string& name, double slope, double factor) {
  BenchVariantResult variant;
  variant.name = name;
  for (const std::uint32_t spp : {4u, 16u, 64u}) {
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
      const double luck = 1 + 0.1 * static_cast<double>(seed);  // the same for every variant
      const double error = factor * luck * std::pow(spp, slope);
      variant.runs.push_back(run_of(spp, seed, 0.5 * spp, error, 2 * error));
    }
    variant.biases.push_back({spp, "G", 0.1, 1.0});
  }
  return variant;
}

TEST(Interval, OfEqualNumbersHasNoWidth) {
  const Interval interval = interval_of({3, 3, 3});
  EXPECT_NEAR(interval.value, 3, 1e-12);
  EXPECT_NEAR(interval.low, 3, 1e-9);
  EXPECT_NEAR(interval.high, 3, 1e-9);
}

TEST(Interval, IsStudentsOverTheLogarithms) {
  // Logarithms 0 and 2: mean 1, standard error 1; t of 95 % with one degree of freedom is 12.7062.
  const Interval interval = interval_of({1, std::exp(2.0)});
  EXPECT_NEAR(std::log(interval.value), 1, 1e-12);
  EXPECT_NEAR(std::log(interval.high), 1 + 12.7062, 1e-3);
  EXPECT_NEAR(std::log(interval.low), 1 - 12.7062, 1e-3);
}

TEST(Interval, OfOneNumberHasNoEnds) {
  EXPECT_EQ(interval_of({5}).value, 5);
  EXPECT_FALSE(interval_of({5}).has_ends());
}

TEST(Student, QuantilesAreThoseOfTheTables) {
  EXPECT_NEAR(student_t_quantile(0.05, 1), 12.7062, 1e-3);
  EXPECT_NEAR(student_t_quantile(0.05, 3), 3.1824, 1e-3);
  EXPECT_NEAR(student_t_quantile(0.05, 1e6), 1.95997, 1e-4);
  EXPECT_NEAR(student_t_quantile(0.01, 10), 3.1693, 1e-3);
}

TEST(Noise, OfTheReferenceIsTakenOffUnlessItIsMostOfTheError) {
  EXPECT_DOUBLE_EQ(without_noise(1.0, 0.25), 0.75);
  EXPECT_DOUBLE_EQ(without_noise(1.0, 0.75), 1.0);
}

TEST(Slope, IsThatOfThePowerLaw) {
  const auto slope = slope_of(variant_of("", -1.3, 1), {});
  ASSERT_TRUE(slope.has_value());
  EXPECT_NEAR(slope->value, -1.3, 1e-9);  // luck is the same at every sample count
  EXPECT_GT(slope->standard_error, 0);
}

TEST(Slope, NeedsTwoSampleCounts) {
  BenchVariantResult variant = variant_of("", -1, 1);
  std::erase_if(variant.runs, [](const BenchRun& run) { return run.spp != 4; });
  EXPECT_FALSE(slope_of(variant, {}).has_value());
}

TEST(Ratio, IsPairedBySeed) {
  // The variants share their luck, so that the ratio has no spread although the efficiencies have.
  const BenchVariantResult a = variant_of("a", -1, 1), b = variant_of("b", -1, 0.5);
  const Interval efficient = interval_over(a, 16, [](const BenchRun& run) { return efficiency(run, {}); });
  EXPECT_LT(efficient.low, 0.9 * efficient.high);
  for (const std::optional<std::uint32_t> spp :
       {std::optional<std::uint32_t>{}, std::optional<std::uint32_t>{16}}) {
    const Interval ratio = efficiency_ratio(a, b, {}, spp);
    EXPECT_NEAR(ratio.value, 2, 1e-9);
    EXPECT_NEAR(ratio.low, 2, 1e-6);
    EXPECT_NEAR(ratio.high, 2, 1e-6);
  }
}

TEST(Report, NamesTheWinner) {
  BenchSceneResult scene{
      .name = "room",
      .reference = "room.exr",
      .noise = {},
      .variants = {variant_of("sampler=sobol", -1, 1), variant_of("sampler=independent", -1, 3)}};
  const std::string text = to_text(scene);
  EXPECT_NE(text.find("all  x 0.333"), std::string::npos) << text;
  EXPECT_NE(text.find("sampler=sobol wins"), std::string::npos) << text;
  EXPECT_NE(text.find("slope of MSE over time  -1.000"), std::string::npos) << text;
}

/// Neighbours whose errors agree: half the error of pixels, twice that of means over blocks.
TEST(Report, TellsPixelsFromMeansOverBlocks) {
  BenchVariantResult a = variant_of("a", -1, 1), b = variant_of("b", -1, 0.5);
  for (BenchRun& run : b.runs) run.relmse_block *= 4;
  EXPECT_NEAR(efficiency_ratio(a, b, {}, 4).value, 2, 1e-9);
  EXPECT_NEAR(efficiency_ratio(a, b, {}, 4, block_efficiency).value, 0.5, 1e-9);
  const BenchSceneResult scene{.name = "room", .reference = "", .noise = {}, .block = 4, .variants = {a, b}};
  const std::string text = to_text(scene);
  const std::size_t of_means = text.find("efficiency of b over a, of means over 4x4 pixels\n");
  ASSERT_NE(of_means, std::string::npos) << text;
  EXPECT_NE(text.find("b wins"), std::string::npos);
  EXPECT_NE(text.find("a wins", of_means), std::string::npos);
  EXPECT_EQ(text.find("b wins", of_means), std::string::npos);
}

TEST(Report, SaysWhenADifferenceIsNotSignificant) {
  BenchVariantResult a = variant_of("a", -1, 1), b = a;
  b.name = "b";
  for (BenchRun& run : b.runs) run.relmse *= run.seed_offset % 2 == 0 ? 1.1 : 0.9;
  const BenchSceneResult scene{.name = "room", .reference = "", .noise = {}, .variants = {a, b}};
  EXPECT_NE(to_text(scene).find("the difference is not significant"), std::string::npos);
}

TEST(Report, JsonHasWhatTheTableHas) {
  const BenchSceneResult scene{
      .name = "room", .reference = "room.exr", .noise = {}, .variants = {variant_of("", -1, 1)}};
  const auto json = nlohmann::json::parse(
      to_json({scene}, {.spp = {4, 16, 64}, .seeds = 4, .threads = 1}, {.processor_model = "m", .load = 2}));
  EXPECT_EQ(json["machine"]["model"], "m");
  EXPECT_EQ(json["machine"]["loaded"], true);
  const auto& variant = json["scenes"][0]["variants"][0];
  EXPECT_EQ(variant["runs"].size(), 12u);
  EXPECT_NEAR(variant["slope"]["value"], -1, 1e-9);
  EXPECT_EQ(variant["efficiency"][1]["spp"], 16);
  EXPECT_EQ(json["scenes"][0]["reference"]["source"], "room.exr");
}

TEST(Report, PlotHasALineAVariantWithErrorBars) {
  const BenchSceneResult scene{.name = "room",
                               .reference = "",
                               .noise = {},
                               .variants = {variant_of("a", -1, 1), variant_of("b", -1, 2)}};
  const LogLogPlot plot = to_plot({scene}, {.spp = {4, 16, 64}, .seeds = 4, .threads = 1});
  ASSERT_EQ(plot.series.size(), 2u);
  EXPECT_EQ(plot.series[0].name, "a  (-1.00)");
  ASSERT_EQ(plot.series[0].points.size(), 3u);
  EXPECT_NEAR(plot.series[0].points[0].x, 2, 1e-9);
  EXPECT_LT(plot.series[0].points[0].low, plot.series[0].points[0].y);
}

/// The variant is biased from 16 samples on.
BenchVariantResult biased_variant() {
  BenchVariantResult variant = variant_of("b", -1, 2);
  for (BenchBias& bias : variant.biases)
    bias.apart = {.bias2 = bias.spp < 16 ? -0.01 : 0.25, .bias2_error = 0.01, .variance = 1.0 / bias.spp};
  return variant;
}

TEST(Report, TellsBiasFromVariance) {
  const BenchSceneResult scene{.name = "room",
                               .reference = "",
                               .noise = {},
                               .variants = {variant_of("a", -1, 1), biased_variant()},
                               .refusals = {{"c", "sees no media"}}};
  const BenchPlan plan{.spp = {4, 16, 64}, .seeds = 4, .threads = 1};
  const std::string text = to_text(scene);
  EXPECT_NE(text.find("       4        0.25       -0.01        0.01  no bias seen\n"), std::string::npos)
      << text;
  EXPECT_NE(text.find("      64     0.01562        0.25        0.01  biased\n"), std::string::npos) << text;
  EXPECT_NE(text.find("not measured: c: sees no media\n"), std::string::npos) << text;

  const LogLogPlot plot = to_bias_plot({scene}, plan);
  ASSERT_EQ(plot.series.size(), 3u) << "two variances, and one bias";
  EXPECT_TRUE(plot.series[2].dashed);
  EXPECT_EQ(plot.series[2].color, plot.series[1].color);
  EXPECT_EQ(plot.series[2].name, "");
  ASSERT_EQ(plot.series[2].points.size(), 2u);
  EXPECT_EQ(plot.series[2].points[0].y, 0.25);
  EXPECT_EQ(plot.series[1].points[0].y, 0.25);
  EXPECT_EQ(to_plot({scene}, plan).series.size(), 3u);

  const auto json = nlohmann::json::parse(to_json({scene}, plan, {}))["scenes"][0];
  EXPECT_EQ(json["variants"][1]["bias"][2]["squared"], 0.25);
  EXPECT_EQ(json["not_measured"][0]["reason"], "sees no media");
}

}  // namespace
}  // namespace tessera::client
