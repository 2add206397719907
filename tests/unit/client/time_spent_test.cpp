#include "command/report/time_spent.h"

#include <gtest/gtest.h>

namespace tessera::client {
namespace {

v1::UnitStats stats_of_ten_seconds() {
  v1::UnitStats stats;
  stats.mutable_cpu_time()->set_seconds(10);
  auto& stages = *stats.mutable_stage_ns();
  stages["build"] = 2'000'000'000;  // not part of the units' ten seconds
  stages["intersection"] = 5'000'000'000;
  stages["shading"] = 4'000'000'000;
  auto& parts = *stats.mutable_shading_part_ns();  // one batch in 16 or so was looked into
  parts["materials"] = 300;
  parts["surfaces"] = 100;
  auto& materials = *stats.mutable_material_ns();
  materials["wood"] = 20;
  materials["paint"] = 10;
  return stats;
}

double seconds_of(const std::vector<TimePart>& parts, const std::string& name) {
  for (const TimePart& part : parts) {
    if (part.name == name) return part.seconds;
  }
  return -1;
}

TEST(TimeSpent, AddsUpToAllThereIs) {
  const TimeSpent spent = time_spent(
      stats_of_ten_seconds(), ProcessTime{.start_seconds = 0.5, .import_seconds = 1, .total_seconds = 14.5});
  EXPECT_DOUBLE_EQ(spent.seconds, 14.5);
  EXPECT_DOUBLE_EQ(seconds_of(spent.stages, "start"), 0.5);
  EXPECT_DOUBLE_EQ(seconds_of(spent.stages, "import"), 1);
  EXPECT_DOUBLE_EQ(seconds_of(spent.stages, "build"), 2);
  EXPECT_DOUBLE_EQ(seconds_of(spent.stages, "other"), 1);
  EXPECT_DOUBLE_EQ(seconds_of(spent.stages, "coordination"), 1);
}

TEST(TimeSpent, SharesOfShadingAreScaledToIt) {
  const TimeSpent spent = time_spent(stats_of_ten_seconds());
  EXPECT_DOUBLE_EQ(seconds_of(spent.shading, "materials"), 3);
  EXPECT_DOUBLE_EQ(seconds_of(spent.shading, "surfaces"), 1);
  EXPECT_DOUBLE_EQ(seconds_of(spent.materials, "wood"), 2);
  EXPECT_DOUBLE_EQ(seconds_of(spent.materials, "paint"), 1);
  EXPECT_EQ(seconds_of(spent.stages, "coordination"), -1) << "a farm's client does not know";
}

TEST(TimeSpent, IsToldInALine) {
  const TimeSpent spent = time_spent(
      stats_of_ten_seconds(), ProcessTime{.start_seconds = 0, .import_seconds = 0, .total_seconds = 20});
  EXPECT_EQ(
      to_text(spent),
      "20 CPU s: build 10 %, intersection 25 %, shading 20 % (materials 15 %, surfaces 5 %), other 5 %, "
      "coordination 40 %\n"
      "materials: wood 10 %, paint 5 %");
  EXPECT_EQ(to_text(time_spent({})), "");
}

}  // namespace
}  // namespace tessera::client
