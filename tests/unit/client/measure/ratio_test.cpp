// Ratios of figures: their errors against those of drawn pairs, and which meters go together.
#include "measure/ratio.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>
#include <string>

#include "google/protobuf/text_format.h"
#include "measure/plan.h"

namespace tessera::client {
namespace {

using testing::HasSubstr;

constexpr auto kKinds = {v1::RatioMeter::QUOTIENT, v1::RatioMeter::WEBER, v1::RatioMeter::MICHELSON};

double value_of(double a, double b, v1::RatioMeter::Kind kind) {
  if (kind == v1::RatioMeter::QUOTIENT) return a / b;
  return kind == v1::RatioMeter::WEBER ? (a - b) / b : (a - b) / (a + b);
}

TEST(Ratio, ErrorsAreThoseOfPairs) {
  constexpr int kPairs = 40000;
  const Figure of{.value = 30, .standard_error = 0.3, .samples = 100, .degrees_of_freedom = 50},
      over{.value = 20, .standard_error = 0.4, .samples = 28, .degrees_of_freedom = 50};
  for (const v1::RatioMeter::Kind kind : kKinds) {
    const Figure ratio = ratio_of(of, over, kind);
    EXPECT_DOUBLE_EQ(ratio.value, value_of(30, 20, kind));
    EXPECT_EQ(ratio.samples, 128u);
    std::mt19937_64 random(kind);
    std::normal_distribution<double> a(of.value, of.standard_error), b(over.value, over.standard_error);
    double mean = 0, squares = 0;
    for (int i = 0; i < kPairs; ++i) {
      const double value = value_of(a(random), b(random), kind), away = value - mean;
      mean += away / (i + 1);
      squares += away * (value - mean);
    }
    // The deviation of so many pairs is known to 1 / sqrt(2 n) = .35 %; terms of second order are below .2 %.
    EXPECT_NEAR(std::sqrt(squares / (kPairs - 1)) / ratio.standard_error, 1, 0.02);
  }
}

TEST(Ratio, HasTheFreedomOfItsParts) {
  const Figure exact{.value = 2}, of{.value = 1, .standard_error = 0.1, .degrees_of_freedom = 15};
  EXPECT_DOUBLE_EQ(ratio_of(of, exact, v1::RatioMeter::QUOTIENT).degrees_of_freedom, 15);
  EXPECT_DOUBLE_EQ(ratio_of(of, of, v1::RatioMeter::QUOTIENT).degrees_of_freedom, 30);
  EXPECT_EQ(ratio_of(exact, exact, v1::RatioMeter::WEBER).standard_error, 0);
  EXPECT_EQ(relative_error_of_ratio(ratio_of(exact, exact, v1::RatioMeter::WEBER), v1::RatioMeter::WEBER), 0);
}

TEST(Ratio, OverNothingThereIsNone) {
  const Figure black{.value = 0, .samples = 64}, of{.value = 1, .standard_error = 0.1};
  for (const v1::RatioMeter::Kind kind : kKinds) {
    const Figure ratio = ratio_of(kind == v1::RatioMeter::MICHELSON ? black : of, black, kind);
    EXPECT_TRUE(std::isnan(ratio.value));
    EXPECT_EQ(ratio.standard_error, 0);
    EXPECT_EQ(relative_error_of_ratio(ratio, kind), 0);
  }
}

absl::StatusOr<MeasurePlan> plan_of_text(const std::string& text) {
  MeterFile file;
  file.path = "meters.textproto";
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &file.list)) << text;
  file.line_of_meter.assign(static_cast<std::size_t>(file.list.meters_size()), 1);
  const ImportedScene imported;
  const auto scene = measured_scene(imported, file, false, [] { return Ball{}; });
  EXPECT_TRUE(scene.ok()) << scene.status();
  return plan_of(file, *scene);
}

constexpr const char* kDesk = "meters { name: 'desk' irradiance { receivers { point {} } } } ";
constexpr const char* kFloor =
    "meters { name: 'floor' irradiance { receivers { plane { edge_u { x: 1 } edge_v { y: 1 } columns: 3 } } "
    "} } ";

TEST(Ratio, IsPlannedOfMetersByName) {
  // The ratio may stand before its meters.
  const auto plan =
      plan_of_text(std::string("meters { name: 'r' ratio { of: 'floor' over: 'desk' } } ") + kDesk + kFloor);
  ASSERT_TRUE(plan.ok()) << plan.status();
  ASSERT_TRUE(plan->meters[0].ratio);
  EXPECT_EQ(plan->meters[0].ratio->of, 2u);
  EXPECT_EQ(plan->meters[0].ratio->over, 1u);
  EXPECT_EQ(plan->meters[0].unit, "1");
  EXPECT_EQ(plan->cells, 4u) << "it has no cells of its own";
}

TEST(Ratio, MetersThatDoNotGoTogetherAreRefused) {
  const auto refused = [](const std::string& more, const std::string& message) {
    const auto plan = plan_of_text(std::string(kDesk) + kFloor + more);
    EXPECT_FALSE(plan.ok());
    EXPECT_THAT(std::string(plan.status().message()), HasSubstr(message));
  };
  refused("meters { name: 'r' ratio { of: 'desk' over: 'sofa' } }", "there is no meter 'sofa'");
  refused("meters { name: 'r' ratio { of: 'desk' } }", "of one meter over another one");
  refused("meters { name: 'r' ratio { of: 'desk' over: 'desk' } }", "not independent");
  refused("meters { name: 'r' ratio { of: 'desk' over: 'floor' } }", "'desk' has 1 figures, 'floor' 3");
  refused("meters { name: 'r' unit: 'lx' ratio { of: 'floor' over: 'desk' } }", "a ratio has no unit");
  refused("meters { name: 'eye' glare { toward { x: 1 } } } meters { ratio { of: 'eye' over: 'desk' } }",
          "no ratios are of these");
  refused(
      "meters { name: 'ray' radiance { ray { toward { x: 1 } } } } meters { ratio { of: 'ray' over: 'desk' } "
      "}",
      "'ray' is in cd/m2, 'desk' in lx");
  refused(std::string(kDesk) + "meters { ratio { of: 'floor' over: 'desk' } }",
          "2 meters have the name 'desk'");
}

}  // namespace
}  // namespace tessera::client
