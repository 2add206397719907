// Whole processes: the command lines, their cost, and how they compare.
#include "bench/whole.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "bench/machine.h"
#include "image/exr.h"
#include "support/process/temp_dir.h"

namespace tessera::client {
namespace whole_test {
namespace {

using ::testing::HasSubstr;

TEST(FillIn, QuotesWhatItPutsIn) {
  const auto line =
      fill_in("render {scene} --spp {spp} > {out}", {{"scene", "a b's;$x"}, {"spp", "4"}, {"out", "o"}});
  ASSERT_TRUE(line.ok()) << line.status();
  EXPECT_EQ(*line, "render 'a b'\\''s;$x' --spp '4' > 'o'");
  // The text that is put in is not looked at again.
  EXPECT_EQ(*fill_in("{scene}", {{"scene", "{spp}"}}), "'{spp}'");
  EXPECT_EQ(*fill_in("a{} {1} {", {}), "a{} {1} {");
  EXPECT_EQ(fill_in("{spq}", {{"spp", "4"}}).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(Process, CostsWhatItAndItsChildrenCompute) {
  // Two shells that count, the second a child of the first.
  const std::string count = "i=0; while [ $i -lt 100000 ]; do i=$((i+1)); done";
  const auto idle = run_process({"sh", "-c", ":"}, {});
  const auto busy = run_process({"sh", "-c", count + "; sh -c '" + count + "'"}, {});
  ASSERT_TRUE(idle.ok() && busy.ok()) << idle.status() << busy.status();
  EXPECT_GT(busy->cpu_seconds, idle->cpu_seconds);
  EXPECT_GT(busy->wall_seconds, 0);
}

TEST(Process, AFailureHasItsLastLine) {
  const absl::Status status = run_process({"sh", "-c", "echo one; echo two >&2; exit 3"}, {}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInternal);
  EXPECT_THAT(std::string(status.message()), HasSubstr("exit code 3: two"));
  EXPECT_FALSE(run_process({"/no/such/program"}, {}).ok());
  EXPECT_THAT(std::string(run_process({"sh", "-c", "kill -9 $$"}, {}).status().message()),
              HasSubstr("signal 9"));
}

TEST(Process, IsKilledWithItsChildrenWhenStopped) {
  std::stop_source stop;
  stop.request_stop();
  const absl::Status status = run_process({"sh", "-c", "sleep 1000; :"}, stop.get_token()).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kCancelled);
}

Image flat_image(float value) {
  Image image;
  image.data = image.display = {0, 0, 32, 32};
  for (const char* const name : {"R", "G", "B"}) std::ranges::fill(image.add(name).values, value);
  return image;
}

/// A side whose process copies a picture.
WholeSide copier(const std::string& name, const std::string& picture, const BenchReference& reference) {
  return {name,
          [picture](std::uint32_t, std::uint64_t, const std::string& output) {
            return absl::StatusOr<std::vector<std::string>>({"cp", picture, output});
          },
          &reference};
}

TEST(Whole, EachSideIsHeldAgainstItsOwnReference) {
  const support::TempDir directory;
  const std::string one = directory / "one.exr", two = directory / "two.exr";
  ASSERT_TRUE(write_exr(flat_image(1), one).ok() && write_exr(flat_image(2), two).ok());
  const BenchReference half{flat_image(0.5f), {}, "half"}, three{flat_image(3), {}, "three"};
  const std::vector<WholeSide> sides{copier("a", one, half), copier("b", two, three)};
  const auto results =
      measure_whole(sides, {.spp = {1, 4}, .seeds = 2, .threads = 1}, [](const std::string&) {}, {});
  ASSERT_TRUE(results.ok()) << results.status();
  ASSERT_EQ(results->size(), 2u);
  ASSERT_EQ((*results)[0].runs.size(), 4u);
  // (T - R)^2 / (R^2 + 0.01).
  for (const WholeRun& run : (*results)[0].runs) EXPECT_NEAR(run.relmse, 0.25 / 0.26, 1e-6);
  for (const WholeRun& run : (*results)[1].runs) EXPECT_NEAR(run.relmse, 1 / 9.01, 1e-6);
  EXPECT_EQ((*results)[1].reference, "three");
  const std::string text = to_text(*results);
  EXPECT_THAT(text, HasSubstr("b; reference: three"));
  EXPECT_THAT(text, HasSubstr("efficiency of a over b"));
}

TEST(Whole, APeerThatLeavesNoPictureIsNamed) {
  const BenchReference reference{flat_image(1), {}, "one"};
  const WholeSide lazy{"lazy",
                       [](std::uint32_t, std::uint64_t, const std::string&) {
                         return absl::StatusOr<std::vector<std::string>>({"true"});
                       },
                       &reference};
  const auto results =
      measure_whole(std::vector{lazy}, {.spp = {1}, .seeds = 1, .threads = 1}, [](const std::string&) {}, {});
  EXPECT_THAT(std::string(results.status().message()), HasSubstr("lazy left no picture"));
}

WholeResult result_of(std::vector<double> seconds) {
  WholeResult result;
  for (std::size_t i = 0; i < seconds.size(); ++i)
    result.runs.push_back({4, i, {.cpu_seconds = seconds[i], .wall_seconds = 1}, 0.1, 0.1});
  return result;
}

TEST(Whole, RatiosArePairedBySeed) {
  // Seeds differ by ten times, sides by two each time.
  const Interval ratio = whole_ratio(result_of({1, 10, 100}), result_of({2, 20, 200}), 4);
  EXPECT_NEAR(ratio.value, 2, 1e-9);
  EXPECT_NEAR(ratio.low, 2, 1e-9);
}

TEST(Machine, IsMarkedWhenOthersWork) {
  EXPECT_FALSE((Machine{.processor_model = "m", .processors = 2, .load = 0.9, .others = 0.4}.is_loaded()));
  EXPECT_TRUE((Machine{.processor_model = "m", .processors = 2, .load = 1.1, .others = 0}.is_loaded()));
  const Machine busy{.processor_model = "m", .processors = 2, .load = 0.2, .others = 1.5};
  EXPECT_TRUE(busy.is_loaded());
  EXPECT_THAT(to_text(busy), HasSubstr("LOADED"));
  const Machine here = MachineWatch().machine();
  EXPECT_GE(here.processors, 1u);
  EXPECT_FALSE(here.processor_model.empty());
}

}  // namespace
}  // namespace whole_test
}  // namespace tessera::client
