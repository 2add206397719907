// When sensors are exposed: times against the densities that they claim, and rows against one another.
#include "render/sensor/shutter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "render/sensor/shutter_table.h"
#include "support/kernel/chi2.h"
#include "support/kernel/random_lanes.h"

namespace tessera::render::TESSERA_ISA::shutters {
namespace {

constexpr int kRows = 16, kColumns = 24;

/// Openness at even times, scaled to a mean of 1.
std::vector<ShutterTable::Knot> knots_of(std::vector<float> open) {
  const auto last = static_cast<float>(open.size() - 1);
  std::vector<ShutterTable::Knot> knots;
  float cdf = 0;
  for (std::size_t i = 0; i < open.size(); ++i) {
    if (i > 0) cdf += (open[i] + open[i - 1]) / (2 * last);
    knots.push_back({static_cast<float>(i) / last, open[i], cdf});
  }
  for (ShutterTable::Knot& knot : knots) knot.openness /= cdf, knot.cdf /= cdf;
  return knots;
}

SensorRecord sensor_with(const ShutterTable& shutter, SensorKind kind = SensorKind::kPinhole) {
  SensorRecord sensor;
  sensor.kind = kind;
  sensor.width = kColumns, sensor.height = kRows;
  sensor.scale_x = 1.0f / kColumns, sensor.scale_y = 1.0f / kRows;
  sensor.shutter = std::make_shared<const ShutterTable>(shutter);
  return sensor;
}

ShutterTable rolling(float duration, std::vector<float> open = {}) {
  ShutterTable shutter;
  if (!open.empty()) shutter.knots = knots_of(std::move(open));
  shutter.rows = kRows;
  shutter.duration = duration;
  return shutter;
}

Vec2 place(float x, float y) { return {Float(x), Float(y)}; }

const std::vector<std::vector<float>> kCurves = {
    {0, 1, 1, 0}, {1, 0}, {0, 1}, {1, 0, 0, 2, 0.5f}, {3, 1, 4, 1, 5, 9, 2, 6}};

TEST(Shutter, TimesHaveTheOpennessAsTheirDensity) {
  constexpr int kSamples = 1 << 16, kCells = 64;
  for (const std::vector<float>& open : kCurves) {
    ShutterTable shutter;
    shutter.knots = knots_of(open);
    const SensorRecord sensor = sensor_with(shutter);
    std::vector<double> observed(kCells), expected(kCells);
    RandomLanes numbers(3);
    for (int i = 0; i < kSamples; i += kWidth) {
      const Float time = time_at(sensor, place(0, 0), numbers());
      for (int l = 0; l < kWidth; ++l) {
        ASSERT_TRUE(time.lane(l) >= 0 && time.lane(l) <= 1) << time.lane(l);
        ++observed[static_cast<std::size_t>(std::min(time.lane(l) * kCells, kCells - 1.0f))];
      }
    }
    // Pieces of the curve are linear: 1,000 midpoints a cell are exact but at its corners.
    const auto& knots = shutter.knots;
    constexpr int kPoints = 1000 * kCells;
    for (int i = 0; i < kPoints; ++i) {
      const double t = (i + 0.5) / kPoints, piece = t * static_cast<double>(knots.size() - 1);
      const auto k = static_cast<std::size_t>(piece);
      const double part = piece - std::floor(piece);
      expected[static_cast<std::size_t>(i / 1000)] +=
          ((1 - part) * knots[k].openness + part * knots[k + 1].openness) * kSamples / kPoints;
    }
    EXPECT_GT(test::chi_square_test(observed, expected).p_value, test::sidak_level(0.001, 5));
    EXPECT_EQ(exposure_at(sensor, place(0, 0), Float(0.5f)).lane(0), 1) << "all of it is exposed at once";
  }
}

TEST(Shutter, RowsAreExposedOneAfterTheOther) {
  struct Case {
    bool across, from_last;
    float x, y;
    int row;  // of those that are exposed, from the first
  };
  const float delay = 0.75f / (kRows - 1);
  for (const Case& c :
       {Case{false, false, 3, 0.5f, 0}, Case{false, false, 3, 4.99f, 4}, Case{false, false, 3, -1.5f, 0},
        Case{false, false, 3, 99, kRows - 1}, Case{false, true, 3, 0.5f, kRows - 1},
        Case{true, false, 4.5f, 3, 4}, Case{true, true, 4.5f, 3, kRows - 1 - 4}}) {
    ShutterTable shutter = rolling(0.25f);
    shutter.across = c.across, shutter.from_last = c.from_last;
    const SensorRecord sensor = sensor_with(shutter);
    const float begin = static_cast<float>(c.row) * delay;
    const Vec2 at = place(c.x, c.y);
    EXPECT_NEAR(time_at(sensor, at, Float(0.0f)).lane(0), begin, 1e-6);
    EXPECT_NEAR(time_at(sensor, at, Float(0.5f)).lane(0), begin + 0.125f, 1e-6);
    EXPECT_EQ(exposure_at(sensor, at, Float(begin - 1e-3f)).lane(0), 0);
    EXPECT_NEAR(exposure_at(sensor, at, Float(begin + 0.1f)).lane(0), 4, 1e-5);
    EXPECT_EQ(exposure_at(sensor, at, Float(begin + 0.251f)).lane(0), 0);
  }
}

TEST(Shutter, PlacesBeyondTheEdgeAreExposedWithThoseThatSeeTheSame) {
  ShutterTable shutter = rolling(0.25f);
  const auto begin = [&](SensorKind kind, float x, float y) {
    return time_at(sensor_with(shutter, kind), place(x, y), Float(0.0f)).lane(0);
  };
  EXPECT_EQ(begin(SensorKind::kEquirectangular, 2, -1.5f), begin(SensorKind::kEquirectangular, 14, 1.5f));
  EXPECT_EQ(begin(SensorKind::kOctahedral, 2, kRows + 1.5f), begin(SensorKind::kOctahedral, 2, kRows - 1.5f));
  shutter.across = true, shutter.rows = kColumns;
  EXPECT_EQ(begin(SensorKind::kEquirectangular, -1.5f, 3), begin(SensorKind::kEquirectangular, 22.5f, 3));
  EXPECT_EQ(begin(SensorKind::kEquirectangular, 2.5f, -0.5f),
            begin(SensorKind::kEquirectangular, 14.5f, 0.5f));
  EXPECT_EQ(begin(SensorKind::kOctahedral, -1.5f, 3), begin(SensorKind::kOctahedral, 1.5f, 3));
}

/// Light of every time that lands on a row counts as much as the row's own samples: the integral of what it
/// counts for is 1, and that of any function of time is the mean over the samples.
TEST(Shutter, TimesOfLightsAndOfSamplesGiveTheSame) {
  constexpr int kSamples = 1 << 16;
  for (const std::vector<float>& open : kCurves) {
    for (const float duration : {1.0f, 0.3f, 0.02f}) {
      const SensorRecord sensor = sensor_with(rolling(duration, open));
      for (const float row : {0.5f, 7.5f, 15.5f}) {
        double one = 0, from_lights = 0, from_samples = 0;
        for (int i = 0; i < kSamples; i += kWidth) {
          const Float u = (Float(static_cast<float>(i) + 0.5f) + to_float(Int::iota(0))) * (1.0f / kSamples);
          const Float light = time_of_light(sensor, u), own = time_at(sensor, place(3, row), u);
          const Float weight = exposure_at(sensor, place(3, row), light);
          for (int l = 0; l < kWidth; ++l) {
            const double t = light.lane(l), s = own.lane(l);
            one += weight.lane(l) / kSamples;
            from_lights += weight.lane(l) * t * t / kSamples;
            from_samples += s * s / kSamples;
          }
        }
        // Midpoints: of a curve's jumps a sample's width over the duration, at most nine times the mean high.
        const double tolerance = 10 / (static_cast<double>(kSamples) * duration) + 1e-5;
        EXPECT_NEAR(one, 1, tolerance) << duration << ", row " << row;
        EXPECT_NEAR(from_lights, from_samples, tolerance) << duration << ", row " << row;
      }
    }
  }
}

/// Groups that share a time: what it counts for at each member integrates to 1, whether rows overlap or not.
TEST(Shutter, GroupsShareTimesWithoutBias) {
  constexpr int kSamples = 1 << 14;
  for (const float duration : {1.0f, 0.2f, 0.01f}) {
    for (const int group : {2, 4, 16}) {
      const SensorRecord sensor = sensor_with(rolling(duration, {0, 1, 1, 0.5f}));
      // Columns of two: members lie in up to eight rows.
      const Vec2 raster{to_float(Int::iota(0) & Int(1)) + 0.5f,
                        to_float(shift_right<1>(Int::iota(0))) + 0.5f};
      std::vector<double> one(kWidth), mean(kWidth), squares(kWidth);
      RandomLanes numbers(17);
      for (int i = 0; i < kSamples; ++i) {
        alignas(64) float u[kWidth];
        numbers().store(u);
        for (int l = 0; l < kWidth; ++l) u[l] = u[l / group * group];
        const Exposure exposure = exposure_of_groups(sensor, raster, Float::load(u), group);
        for (int l = 0; l < kWidth; ++l) {
          const double w = exposure.weight.lane(l);
          one[static_cast<std::size_t>(l)] += w / kSamples;
          squares[static_cast<std::size_t>(l)] += w * w / kSamples;
          mean[static_cast<std::size_t>(l)] += w * exposure.time.lane(l) / kSamples;
          EXPECT_EQ(exposure.time.lane(l), exposure.time.lane(l / group * group));
          ASSERT_LE(w, group * 1.001);
        }
      }
      double expected = 0;  // of a row that begins at 0
      for (int i = 0; i < kSamples; i += kWidth) {
        const Float time =
            time_at(sensor, place(0, 0.5f),
                    (Float(static_cast<float>(i) + 0.5f) + to_float(Int::iota(0))) * (1.0f / kSamples));
        for (int l = 0; l < kWidth; ++l) expected += static_cast<double>(time.lane(l)) / kSamples;
      }
      for (int l = 0; l < kWidth; ++l) {
        const auto at = static_cast<std::size_t>(l);
        const int row = l / 2;
        const double begin = row * (1 - duration) / (kRows - 1.0);
        // 5.5 standard errors: one false alarm in 180,000 programs, of 144 numbers each.
        const double error = 5.5 * std::sqrt(std::max(squares[at] - 1, 0.0) / kSamples) + 1e-4;
        EXPECT_NEAR(one[at], 1, error) << duration << ", group " << group << ", lane " << l;
        EXPECT_NEAR(mean[at], begin + expected, error + 5.5 * duration / std::sqrt(double{kSamples}))
            << duration << ", group " << group << ", lane " << l;
      }
    }
  }
}

TEST(Shutter, WithoutATableTimesAreTheNumbers) {
  const SensorRecord sensor;
  EXPECT_EQ(time_at(sensor, place(1, 2), Float(0.375f)).lane(0), 0.375f);
  EXPECT_EQ(time_of_light(sensor, Float(0.375f)).lane(0), 0.375f);
  EXPECT_EQ(exposure_at(sensor, place(1, 2), Float(0.375f)).lane(0), 1);
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA::shutters
