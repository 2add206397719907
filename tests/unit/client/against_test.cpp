// Results against those of a file.
#include "bench/against.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bench/report.h"

namespace tessera::client {
namespace against_test {
namespace {

using ::testing::HasSubstr;

const BenchPlan kPlan{.spp = {4, 16}, .seeds = 3, .threads = 1};
const Machine kQuiet{.processor_model = "model", .processors = 2, .load = 0.1, .others = 0};

/// `slowness`: of everything; `waste`: of rendering beside the rays, seed by seed up to 1 % more or less.
BenchSceneResult scene_of(double slowness, double waste) {
  BenchVariantResult variant;
  for (const std::uint32_t spp : kPlan.spp) {
    for (std::uint64_t seed = 0; seed < kPlan.seeds; ++seed) {
      BenchRun run;
      run.spp = spp, run.seed_offset = seed;
      run.cost.cpu_seconds = slowness * waste * spp * (0.99 + 0.01 * static_cast<double>(seed));
      run.relmse = run.relmse_trimmed = (1.0 + static_cast<double>(seed)) / spp;
      variant.runs.push_back(run);
    }
  }
  variant.ceiling.rays = 1000;
  variant.ceiling.render_cpu_seconds = 2 * slowness * waste;
  variant.ceiling.replay_cpu_seconds = slowness;
  return {.name = "room", .reference = "", .noise = {}, .variants = {variant}};
}

BenchChanges changes(double slowness, double waste, const Machine& then = kQuiet,
                     const Machine& now = kQuiet) {
  const absl::StatusOr<BenchChanges> found =
      changes_since(to_json({scene_of(1, 1)}, kPlan, then), {scene_of(slowness, waste)}, now);
  EXPECT_TRUE(found.ok()) << found.status();
  EXPECT_EQ(found->changes.size(), 1u);
  return *found;
}

TEST(Against, ARegressionShows) {
  const BenchChanges slower = changes(1, 1.2);
  EXPECT_TRUE(slower.same_machine);
  EXPECT_NEAR(slower.changes[0].ratio.value, 1 / 1.2, 1e-9);
  EXPECT_THAT(to_text(slower), HasSubstr("REGRESSION"));
  EXPECT_THAT(to_text(changes(1, 0.8)), HasSubstr("better"));
  EXPECT_THAT(to_text(changes(1, 1.01)), HasSubstr("as before"));
}

TEST(Against, OtherMachinesAreComparedByTheirRays) {
  Machine other = kQuiet;
  other.processor_model = "another model";
  const BenchChanges slow_machine = changes(3, 1, kQuiet, other);
  EXPECT_FALSE(slow_machine.same_machine);
  EXPECT_NEAR(slow_machine.changes[0].ratio.value, 1.0 / 3, 1e-9);
  EXPECT_NEAR(slow_machine.changes[0].by_rays.value, 1, 1e-9);
  EXPECT_THAT(to_text(slow_machine), HasSubstr("as before"));
  EXPECT_THAT(to_text(changes(3, 1.2, kQuiet, other)), HasSubstr("REGRESSION"));
}

TEST(Against, FiguresOfALoadedMachineAreNotTakenByTheClock) {
  Machine loaded = kQuiet;
  loaded.others = 1.8;
  EXPECT_FALSE(changes(1, 1, loaded, kQuiet).same_machine);
  EXPECT_FALSE(changes(1, 1, kQuiet, loaded).same_machine);
}

TEST(Against, WhatWasNotMeasuredThenIsNamed) {
  BenchSceneResult other = scene_of(1, 1);
  other.name = "hall";
  const auto found = changes_since(to_json({scene_of(1, 1)}, kPlan, kQuiet), {other}, kQuiet);
  ASSERT_TRUE(found.ok());
  EXPECT_TRUE(found->changes.empty());
  EXPECT_THAT(to_text(*found), HasSubstr("not measured then with these settings: hall"));
}

TEST(Against, AFileThatIsNotThereIsNamed) {
  EXPECT_THAT(std::string(read_results("/no/such/file.json").status().message()),
              HasSubstr("/no/such/file.json"));
}

TEST(Against, AnyOtherTextIsRefused) {
  for (const char* const text : {"", "[]", "{}", "{\"scenes\": 3}", "{\"scenes\": [{\"name\": 1}]}",
                                 "{\"version\": \"1\", \"machine\": {}, \"scenes\": []}"}) {
    EXPECT_EQ(changes_since(text, {scene_of(1, 1)}, kQuiet).status().code(),
              absl::StatusCode::kInvalidArgument)
        << text;
  }
}

}  // namespace
}  // namespace against_test
}  // namespace tessera::client
