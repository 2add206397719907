// Apertures and barrels of thin lenses: which points rays leave, and which they are joined to.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "statistical/sensor/askew_sensors.h"
#include "support/kernel/chi2.h"
#include "support/kernel/random_lanes.h"

namespace tessera::render::TESSERA_ISA {
namespace {

struct Corner {
  double x, y;
};

/// The part of a convex polygon where a x + b y <= c [Sutherland & Hodgman 1974].
std::vector<Corner> cut(const std::vector<Corner>& polygon, double a, double b, double c) {
  std::vector<Corner> left;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Corner p = polygon[i], q = polygon[(i + 1) % polygon.size()];
    const double before = a * p.x + b * p.y - c, after = a * q.x + b * q.y - c;
    if (before <= 0) left.push_back(p);
    if ((before < 0) == (after < 0) || before == 0 || after == 0) continue;
    const double t = before / (before - after);
    left.push_back({p.x + t * (q.x - p.x), p.y + t * (q.y - p.y)});
  }
  return left;
}

double area_of(const std::vector<Corner>& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Corner p = polygon[i], q = polygon[(i + 1) % polygon.size()];
    twice += p.x * q.y - p.y * q.x;
  }
  return twice / 2;
}

constexpr std::uint32_t kRoundCorners = 20000;  // a circle's area to a part in 10^7

struct ApertureCase {
  std::uint32_t blades = 0;
  double degrees = 0, ratio = 1;

  std::vector<Corner> polygon(double radius) const {
    const std::uint32_t corners = blades > 0 ? blades : kRoundCorners;
    std::vector<Corner> polygon;
    for (std::uint32_t i = 0; i < corners; ++i) {
      const double angle = degrees * std::numbers::pi / 180 + 2 * std::numbers::pi * i / corners;
      polygon.push_back({radius * std::cos(angle) / ratio, radius * std::sin(angle)});
    }
    return polygon;
  }
};
constexpr ApertureCase kApertures[] = {{3, 90, 1},    {4, 10, 1},   {5, 20, 1.7}, {6, -400, 2},
                                       {7, 123, 0.6}, {64, 1, 1.2}, {0, 0, 2}};

/// The points of the lens that rays leave, against the areas of the polygon that are cut out by a grid.
TEST(SensorAperture, IsLeftEvenly) {
  constexpr int kSamples = 1 << 18, kSeeds = 4, kGrid = 24;
  constexpr int kTests = 2 * static_cast<int>(std::size(kApertures));
  for (const SensorKind kind : {SensorKind::kPinhole, SensorKind::kOrthographic}) {
    for (const ApertureCase& aperture : kApertures) {
      const SensorRecord c =
          sensor_of(kind, {0.4f, aperture_of(aperture.blades, aperture.degrees, aperture.ratio)}, 1);
      const std::vector<Corner> polygon = aperture.polygon(0.4);
      const double side = 0.4 * std::max(1.0, 1 / aperture.ratio), cell = 2 * side / kGrid;
      std::vector<double> expected(kGrid * kGrid);
      for (int i = 0; i < kGrid * kGrid; ++i) {
        const int column = i % kGrid, row = i / kGrid;
        const double x = -side + column * cell, y = -side + row * cell;
        const auto part = cut(cut(cut(cut(polygon, -1, 0, -x), 1, 0, x + cell), 0, -1, -y), 0, 1, y + cell);
        expected[static_cast<std::size_t>(i)] = kSamples * area_of(part) / area_of(polygon);
      }
      double log_of_all = 0;
      for (int seed = 0; seed < kSeeds; ++seed) {
        std::vector<double> observed(kGrid * kGrid);
        RandomLanes numbers(static_cast<std::uint64_t>(seed));
        for (int i = 0; i < kSamples; i += kWidth) {
          // The middle of the film, where parallel rays leave the lens around the origin too.
          const SensorRay ray =
              start_ray(c, {{Float(kMiddleX), Float(kMiddleY)}, {numbers(), numbers()}, Float(0.0f)});
          for (int l = 0; l < kWidth; ++l) {
            const int column = static_cast<int>(std::floor((ray.origin.y.lane(l) + side) / cell)),
                      row = static_cast<int>(std::floor((ray.origin.z.lane(l) + side) / cell));
            ++observed[static_cast<std::size_t>(std::clamp(row, 0, kGrid - 1) * kGrid +
                                                std::clamp(column, 0, kGrid - 1))];
          }
        }
        log_of_all += std::log(std::max(test::chi_square_test(observed, expected).p_value, 1e-300));
      }
      // All seeds together [Fisher 1925].
      EXPECT_GT(test::regularized_gamma_q(kSeeds, -log_of_all), test::sidak_level(0.01, kTests))
          << static_cast<int>(kind) << ", " << aperture.blades << " blades";
    }
  }
}

/// The points of the lens that rays leave, against the brightness of the picture that it is.
TEST(SensorAperture, OfAPictureIsLeftAsItIsBright) {
  constexpr int kSamples = 1 << 18, kSeeds = 4, kFine = 4;
  double total = 0;
  for (const float cell : kCells) total += double{cell};
  for (const double ratio : {1.0, 1.6}) {
    const SensorRecord c = sensor_of(SensorKind::kPinhole, {0.4f, aperture_of(0, 0, ratio), true}, 1);
    std::vector<double> expected;
    for (int row = 0; row < 4 * kFine; ++row) {
      for (int column = 0; column < 6 * kFine; ++column) {
        const int from = row / kFine * 6 + column / kFine;
        expected.push_back(kSamples * double{kCells[static_cast<std::size_t>(from)]} / total /
                           (kFine * kFine));
      }
    }
    double log_of_all = 0;
    for (int seed = 0; seed < kSeeds; ++seed) {
      std::vector<double> observed(expected.size());
      RandomLanes numbers(static_cast<std::uint64_t>(seed) + 31);
      for (int i = 0; i < kSamples; i += kWidth) {
        const SensorRay ray =
            start_ray(c, {{Float(kMiddleX), Float(kMiddleY)}, {numbers(), numbers()}, Float(0.0f)});
        for (int l = 0; l < kWidth; ++l) {
          const double x = ray.origin.y.lane(l) / 0.4 * ratio, y = ray.origin.z.lane(l) / 0.4;
          const int column = std::clamp(static_cast<int>((x + 1) / 2 * 6 * kFine), 0, 6 * kFine - 1),
                    row = std::clamp(static_cast<int>((y + 1) / 2 * 4 * kFine), 0, 4 * kFine - 1);
          ++observed[static_cast<std::size_t>(row * 6 * kFine + column)];
        }
      }
      log_of_all += std::log(std::max(test::chi_square_test(observed, expected).p_value, 1e-300));
    }
    EXPECT_GT(test::regularized_gamma_q(kSeeds, -log_of_all), test::sidak_level(0.01, 2)) << ratio;
  }
}

SensorRecord sensor_with_barrel() {
  SensorRecord c = sensor_of(SensorKind::kPinhole, 0.4f, 1);
  auto table = std::make_shared<LensTable>();
  table->barrel_length = 0.8f, table->barrel_radius = 1.2f;
  c.lens = std::move(table);
  c.has_barrel = true;
  return c;
}

/// The area that two circles have in common, over that of the first.
double common_part(double r1, double r2, double apart) {
  using std::numbers::pi;
  if (apart >= r1 + r2) return 0;
  if (apart <= std::abs(r1 - r2)) return std::min(1.0, r2 * r2 / (r1 * r1));
  const double a = std::acos((apart * apart + r1 * r1 - r2 * r2) / (2 * apart * r1)),
               b = std::acos((apart * apart + r2 * r2 - r1 * r1) / (2 * apart * r2));
  return (r1 * r1 * (a - std::sin(2 * a) / 2) + r2 * r2 * (b - std::sin(2 * b) / 2)) / (pi * r1 * r1);
}

/// The part of rays that leaves a barrel: of the lens, what is within the image of the barrel's circle, as
/// the plane of focus shows it. A ray from the point L to the focus F = f (x, y, 1) is at L + (F - L) D / f
/// there.
TEST(SensorBarrel, OpensWhatTwoCirclesHaveInCommon) {
  const SensorRecord c = sensor_with_barrel();
  const double radius = 0.4, length = 0.8 * radius, opening = 1.2 * radius, f = 3;
  constexpr int kSamples = 1 << 16;
  RandomLanes numbers(5);
  for (const float column : {20.5f, 26.0f, 30.0f, 36.0f, 39.5f}) {
    const double x = double{column} * 0.1 - 2, y = 1 - 10.5 * 0.1;
    double open = 0;
    for (int i = 0; i < kSamples; i += kWidth) {
      const SensorRay ray =
          start_ray(c, {{Float(column), Float(10.5f)}, {numbers(), numbers()}, Float(0.0f)});
      open += std::popcount(ray.valid.bits());
      EXPECT_EQ((ray.weight == 0.0f).bits(), (~ray.valid).bits());
    }
    const double shrink = 1 - length / f;
    const double expected = common_part(radius, opening / shrink, std::hypot(x, y) * length / shrink);
    const double part = open / kSamples;
    EXPECT_NEAR(part, expected, 5 * std::sqrt(0.25 / kSamples)) << column;
    if (column > 39) {
      EXPECT_LT(part, 0.6);
    }
  }
}

/// Points that a ray meets are joined to the place that it came from, if it was not blocked.
TEST(SensorBarrel, ConnectionsAreBlockedAsRaysAre) {
  const SensorRecord c = sensor_with_barrel();
  RandomLanes numbers(15);
  int open = 0, blocked = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec2 raster{numbers(0, kWidthPixels), numbers(0, kHeightPixels)}, u{numbers(), numbers()};
    const SensorRay ray = start_ray(c, {raster, u, Float(0.0f)});
    // Blocked rays have directions, too.
    const Vec3 point = fma(ray.direction, exp(numbers(0, 3)), ray.origin);
    const SensorConnection seen = connect_to_sensor(c, point, u, Float(0.0f), Mask::all());
    for (int l = 0; l < kWidth; ++l) {
      const bool left = (ray.valid.bits() >> l & 1) != 0, joined = (seen.valid.bits() >> l & 1) != 0;
      left ? ++open : ++blocked;
      if (left == joined) continue;
      ADD_FAILURE() << raster.x.lane(l) << " " << raster.y.lane(l);
    }
  }
  EXPECT_GT(open, 10000);
  EXPECT_GT(blocked, 1000);
}

/// Close samples leave close points, so that strata stay in one piece; and corners and middles of edges are
/// reached but not passed.
TEST(SensorAperture, IsReachedInOnePiece) {
  constexpr float kStep = 1e-3f;
  for (const ApertureCase& aperture : kApertures) {
    const SensorRecord c = sensor_of(SensorKind::kPinhole,
                                     {1, aperture_of(aperture.blades, aperture.degrees, aperture.ratio)}, 1);
    const std::vector<Corner> polygon = aperture.polygon(1);
    RandomLanes numbers(3);
    std::vector<double> nearest(polygon.size(), 1e9);
    double farthest = 0, beyond = 0;
    for (int i = 0; i < (1 << 16); i += kWidth) {
      const Vec2 middle{Float(kMiddleX), Float(kMiddleY)};
      const Vec2 u{numbers(0, 1 - kStep), numbers(0, 1 - kStep)};
      const Vec3 a = start_ray(c, {middle, u, Float(0.0f)}).origin,
                 b = start_ray(c, {middle, {u.x + kStep, u.y + kStep}, Float(0.0f)}).origin;
      for (int l = 0; l < kWidth; ++l) {
        farthest = std::max(farthest, double{length(b - a).lane(l)});
        const double x = a.y.lane(l), y = a.z.lane(l);
        if (aperture.blades == 0) {
          beyond = std::max(beyond, std::hypot(x * aperture.ratio, y) - 1);
          continue;
        }
        for (std::size_t k = 0; k < polygon.size(); ++k) {
          const Corner p = polygon[k], q = polygon[(k + 1) % polygon.size()];
          const double edge = std::hypot(q.x - p.x, q.y - p.y);
          beyond = std::max(beyond, ((x - p.x) * (q.y - p.y) - (y - p.y) * (q.x - p.x)) / edge);
          nearest[k] = std::min(nearest[k], std::hypot(x - p.x, y - p.y));
        }
      }
    }
    // The map of the disk spreads lengths up to pi / sqrt(2) times along each side, that of sectors less.
    EXPECT_LT(farthest, 10 * kStep * std::max(1.0, 1 / aperture.ratio)) << aperture.blades;
    EXPECT_LT(beyond, 2e-6) << aperture.blades;
    for (std::size_t k = 0; aperture.blades > 0 && k < polygon.size(); ++k)
      EXPECT_LT(nearest[k], 0.05) << aperture.blades << ", corner " << k;
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
