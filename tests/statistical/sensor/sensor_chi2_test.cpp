// Cameras: rays against the density that a film implies, and the importance that light tracing uses against
// rays.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "render/sampling/warp.h"
#include "render/sensor/lens_table.h"
#include "render/sensor/sensor.h"
#include "support/kernel/chi2.h"
#include "support/kernel/random_lanes.h"

namespace tessera::render::TESSERA_ISA {
namespace {

constexpr int kWidthPixels = 40, kHeightPixels = 20, kMiddleX = kWidthPixels / 2,
              kMiddleY = kHeightPixels / 2;

/// 40 x 20 pixels of [-2, 2] x [-1, 1], turned, and scaled by `scale` where told.
SensorRecord sensor_of(SensorKind kind, float lens_radius, float scale) {
  SensorRecord c;
  c.kind = lens_radius > 0 ? with_lens(kind) : kind;
  // x right, y up, z forward: a rotation about (1, 1, 1), which permutes the axes.
  for (float& m : c.render_from_sensor.m) m = 0;
  c.render_from_sensor.m[2] = c.render_from_sensor.m[4] = c.render_from_sensor.m[9] = scale;
  c.width = kWidthPixels;
  c.height = kHeightPixels;
  c.scale_x = 0.1f, c.offset_x = -2;
  c.scale_y = -0.1f, c.offset_y = 1;
  c.lens_radius = lens_radius;
  c.focal_distance = 3;
  return c;
}

/// Brightness of a picture of 6 x 4 cells, of which two are nearly dark.
const std::vector<float> kCells = {1,     0.05f, 2, 1,    3, 0.5f, 0.5f, 1, 4,     1,     2, 2,
                                   0.05f, 3,     1, 2.5f, 1, 1,    1.5f, 2, 0.25f, 0.75f, 1, 2};
struct Lens {
  float radius = 0;
  std::optional<ApertureRecord> aperture = {};
  bool picture = false;
};
SensorRecord sensor_of(SensorKind kind, const Lens& lens, float scale) {
  SensorRecord c = sensor_of(kind, lens.radius, scale);
  if (!lens.aperture) return c;
  auto table = std::make_shared<LensTable>();
  table->aperture = *lens.aperture;
  if (lens.picture) table->picture.density = Piecewise2d::build(kCells, 6, 4);
  c.lens = std::move(table);
  return c;
}

/// Where rays cross the plane of depth `depth` (camera space), in units of camera space, against the uniform
/// density over what the film covers there. In focus only: elsewhere a lens blurs the border.
TEST(SensorChi2, RaysCoverThePlaneOfFocusEvenly) {
  constexpr int kSamples = 1 << 19, kTests = 8;
  for (const SensorKind kind : {SensorKind::kPinhole, SensorKind::kOrthographic}) {
    for (const float lens : {0.0f, 0.4f}) {
      for (const float scale : {1.0f, 2.5f}) {
        const SensorRecord c = sensor_of(kind, lens, scale);
        const double spread = kind == SensorKind::kPinhole ? 3 : 1;
        std::vector<double> observed(40 * 20), expected(40 * 20, kSamples / 800.0);
        std::vector<double> lens_observed(16 * 16);
        RandomLanes numbers(11);
        for (int i = 0; i < kSamples; i += kWidth) {
          const SensorRay ray = start_ray(
              c,
              {{numbers(0, kWidthPixels), numbers(0, kHeightPixels)}, {numbers(), numbers()}, Float(0.0f)});
          for (int l = 0; l < kWidth; ++l) {
            const double dx = ray.direction.x.lane(l), ox = ray.origin.x.lane(l);
            const double t = (3 * scale - ox) / dx;
            const double right = (ray.origin.y.lane(l) + t * ray.direction.y.lane(l)) / scale,
                         up = (ray.origin.z.lane(l) + t * ray.direction.z.lane(l)) / scale;
            const int column = static_cast<int>(std::floor((right / spread + 2) * 10)),
                      row = static_cast<int>(std::floor((1 - up / spread) * 10));
            // On the border a float may round to either side.
            ++observed[static_cast<std::size_t>(std::clamp(row, 0, 19) * 40 + std::clamp(column, 0, 39))];
            ASSERT_NEAR(std::clamp(row, 0, 19), row, 1);
            ASSERT_NEAR(std::clamp(column, 0, 39), column, 1);
          }
        }
        EXPECT_GT(test::chi_square_test(observed, expected).p_value, test::sidak_level(0.01, kTests))
            << static_cast<int>(kind) << ", lens " << lens << ", scale " << scale;
      }
    }
  }
}

/// The directions of a pinhole's rays: density 1 / (film area cos^3) over solid angle, which integrates to 1
/// over the film.
TEST(SensorChi2, DirectionsOfAPinhole) {
  constexpr int kSamples = 1 << 20;
  const SensorRecord c = sensor_of(SensorKind::kPinhole, 0, 1);
  const test::SphereGrid grid(48, 96);
  std::vector<double> observed(grid.size()), expected(grid.size());
  RandomLanes numbers(11);
  for (int i = 0; i < kSamples; i += kWidth) {
    const SensorRay ray = start_ray(
        c, {{numbers(0, kWidthPixels), numbers(0, kHeightPixels)}, {numbers(), numbers()}, Float(0.0f)});
    for (int l = 0; l < kWidth; ++l)
      ++observed[grid.cell(ray.direction.y.lane(l), ray.direction.z.lane(l), ray.direction.x.lane(l))];
  }
  const auto pdf = [](double x, double y, double z) {
    return z > 0 && std::abs(x) <= 2 * z && std::abs(y) <= z ? 1 / (8 * z * z * z) : 0.0;
  };
  double total = 0;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const double p = test::integrate_cell(pdf, grid.bounds(i), 1e-7, 12);
    expected[i] = kSamples * p;
    total += p;
  }
  // The film's border crosses cells; refined twelve times, what is left of it is far below this.
  EXPECT_NEAR(total, 1, 1e-3);
  EXPECT_GT(test::chi_square_test(observed, expected).p_value, 0.01);
}

struct Corner {
  double x, y;
};

/// What is left of a convex polygon where a x + b y <= c [Sutherland & Hodgman 1974].
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
TEST(SensorChi2, RaysLeaveTheApertureEvenly) {
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
TEST(SensorChi2, RaysLeaveAPictureAsBrightAsItIs) {
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
    if (column > 39) EXPECT_LT(part, 0.6);
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

/// Every pixel's importance over any surface in its view integrates to 1, over lens and surface: radiance 1
/// gives a pixel of value 1. A plane askew, sampled evenly; and no light lands where the film is not.
TEST(SensorChi2, ImportanceOfEveryPixelIntegratesToOne) {
  constexpr int kSamples = 1 << 21;
  const Lens lenses[] = {{}, {0.4f}, {0.4f, aperture_of(5, 20, 1.7)}, {0.4f, aperture_of(0, 0, 1.3), true}};
  for (const SensorKind kind : {SensorKind::kPinhole, SensorKind::kOrthographic}) {
    for (const Lens& lens : lenses) {
      for (const float scale : {1.0f, 2.5f}) {
        const SensorRecord c = sensor_of(kind, lens, scale);
        // Depth 5 + 0.15 right - 0.1 up, in camera space; the square of sides 36 (or 8) about the axis holds
        // all that is seen.
        const float half = kind == SensorKind::kPinhole ? 18.0f : 4.0f;
        const double tilt = std::sqrt(1 + 0.15 * 0.15 + 0.1 * 0.1);
        std::vector<double> sum(800), squares(800);
        RandomLanes numbers(11);
        for (int i = 0; i < kSamples; i += kWidth) {
          const Float right = numbers(-half, half), up = numbers(-half, half);
          const Float depth = fma(right, Float(0.15f), fma(up, Float(-0.1f), Float(5.0f)));
          const Vec3 p = Vec3{depth, right, up} * scale;
          const SensorConnection seen =
              connect_to_sensor(c, p, {numbers(), numbers()}, Float(0.0f), Mask::all());
          const Vec3 w = normalize(seen.lens - p);
          for (int l = 0; l < kWidth; ++l) {
            const double column = std::floor(seen.raster.x.lane(l)), row = std::floor(seen.raster.y.lane(l));
            if (!(seen.valid.bits() >> l & 1) || !(column >= 0 && column < 40 && row >= 0 && row < 20))
              continue;
            const double cosine = std::abs(w.x.lane(l) - 0.15 * w.y.lane(l) + 0.1 * w.z.lane(l)) / tilt;
            const double value = seen.importance.lane(l) * cosine * 4.0 * half * half * scale * scale * tilt;
            const auto pixel = static_cast<std::size_t>(row * 40 + column);
            sum[pixel] += value;
            squares[pixel] += value * value;
          }
        }
        // Each pixel's z is close to normal (hundreds of hits a pixel); 800 of them: the sum of squares has
        // mean 800, deviation 40; five of those. And all together to a part in a thousand.
        double chi2 = 0, all = 0;
        for (std::size_t i = 0; i < 800; ++i) {
          const double mean = sum[i] / kSamples, variance = (squares[i] / kSamples - mean * mean) / kSamples;
          ASSERT_GT(variance, 0) << i;
          chi2 += (mean - 1) * (mean - 1) / variance;
          all += mean / 800;
        }
        EXPECT_NEAR(chi2, 800, 200) << static_cast<int>(kind) << ", lens " << &lens - lenses << ", scale "
                                    << scale;
        EXPECT_NEAR(all, 1, 5e-3);
      }
    }
  }
}

// ---------------------------------------------------------------- sensors whose rays go anywhere

constexpr SensorKind kAboutPoint[] = {SensorKind::kEquirectangular,    SensorKind::kOctahedral,
                                      SensorKind::kCylindrical,        SensorKind::kFisheyeEquidistant,
                                      SensorKind::kFisheyeEquisolid,   SensorKind::kFisheyeStereographic,
                                      SensorKind::kFisheyeOrthographic};

/// The same as sensor_of(); of sensors that see all around, the raster is the unit square. Fisheyes have a
/// circle.
SensorRecord sensor_about_point(SensorKind kind, float scale) {
  SensorRecord c = sensor_of(kind, 0, scale);
  if (edges_of(c) != RasterEdges::kOpen) {
    c.scale_x = 1.0f / kWidthPixels, c.offset_x = 0;
    c.scale_y = 1.0f / kHeightPixels, c.offset_y = 0;
  }
  c.circle_angle = 1.4f;
  return c;
}

TEST(SensorAboutAPoint, ConnectionsLeadToWhereTheRayBegan) {
  for (const SensorKind kind : kAboutPoint) {
    SCOPED_TRACE(static_cast<int>(kind));
    const SensorRecord c = sensor_about_point(kind, 2.5f);
    RandomLanes numbers(11);
    int valid = 0;
    for (int i = 0; i < 1000; ++i) {
      const Vec2 raster{numbers(0, kWidthPixels), numbers(0, kHeightPixels)};
      const SensorRay ray = start_ray(c, middle_sample(raster));
      const Vec3 point = fma(ray.direction, exp(numbers(-5, 5)), ray.origin);
      const SensorConnection seen =
          connect_to_sensor(c, point, {Float(0.5f), Float(0.5f)}, Float(0.0f), Mask::all());
      const std::uint32_t both = (ray.valid & seen.valid).bits();
      EXPECT_EQ(both, ray.valid.bits());
      for (int l = 0; l < kWidth; ++l) {
        if (!(both >> l & 1)) continue;
        ++valid;
        EXPECT_NEAR(seen.raster.y.lane(l), raster.y.lane(l), 1e-3);
        // Near a pole, all longitudes are close to each other.
        const double pole = kind == SensorKind::kEquirectangular
                                ? std::sin(std::numbers::pi * raster.y.lane(l) / kHeightPixels)
                                : 1;
        EXPECT_NEAR(seen.raster.x.lane(l), raster.x.lane(l), 1e-3 / std::max(pole, 1e-3));
      }
    }
    EXPECT_GT(valid, 1000);
  }
}

/// The same as of flat films, over a sphere: and pixels of which a part sees nothing have that part of 1.
TEST(SensorAboutAPoint, ImportanceOfEveryPixelIntegratesToOne) {
  constexpr int kSamples = 1 << 21, kGrid = 32;
  for (const SensorKind kind : kAboutPoint) {
    SCOPED_TRACE(static_cast<int>(kind));
    const SensorRecord c = sensor_about_point(kind, 2.5f);
    std::vector<double> sum(800), squares(800), expected(800);
    for (int pixel = 0; pixel < 800; ++pixel) {
      for (int place = 0; place < kGrid * kGrid; place += kWidth) {
        alignas(64) float x[kWidth], y[kWidth];
        for (int l = 0; l < kWidth; ++l) {
          const auto column = pixel % 40, row = pixel / 40;
          const auto part_x = (place + l) % kGrid, part_y = (place + l) / kGrid;
          x[l] = static_cast<float>(column) + (static_cast<float>(part_x) + 0.5f) / kGrid;
          y[l] = static_cast<float>(row) + (static_cast<float>(part_y) + 0.5f) / kGrid;
        }
        const SensorRay ray = start_ray(c, middle_sample({Float::load(x), Float::load(y)}));
        expected[static_cast<std::size_t>(pixel)] += std::popcount(ray.valid.bits()) / double{kGrid * kGrid};
      }
    }
    RandomLanes numbers(11);
    const double radius = 7;
    for (int i = 0; i < kSamples; i += kWidth) {
      const Vec3 p = square_to_sphere({numbers(), numbers()}) * static_cast<float>(radius);
      const SensorConnection seen =
          connect_to_sensor(c, p, {Float(0.5f), Float(0.5f)}, Float(0.0f), Mask::all());
      for (int l = 0; l < kWidth; ++l) {
        const double column = std::floor(seen.raster.x.lane(l)), row = std::floor(seen.raster.y.lane(l));
        if (!(seen.valid.bits() >> l & 1) || !(column >= 0 && column < 40 && row >= 0 && row < 20)) continue;
        const double value = seen.importance.lane(l) * 4 * std::numbers::pi * radius * radius;
        const auto pixel = static_cast<std::size_t>(row * 40 + column);
        sum[pixel] += value;
        squares[pixel] += value * value;
      }
    }
    double chi2 = 0, all = 0, of_rays = 0;
    int pixels = 0;
    for (std::size_t i = 0; i < 800; ++i) {
      const double mean = sum[i] / kSamples, variance = (squares[i] / kSamples - mean * mean) / kSamples;
      all += mean / 800, of_rays += expected[i] / 800;
      if (expected[i] == 0) {
        // A border that the grid of rays missed.
        EXPECT_LT(mean, 0.01) << i;
        continue;
      }
      // Where a pixel is cut, the grid of its rays is right to a part in a hundred.
      ASSERT_GT(variance, 0) << i;
      chi2 += (mean - expected[i]) * (mean - expected[i]) / (variance + (expected[i] < 1 ? 1e-4 : 0));
      ++pixels;
    }
    EXPECT_NEAR(chi2, pixels, 5 * std::sqrt(2.0 * pixels));
    EXPECT_NEAR(all, of_rays, 5e-3);
    EXPECT_GT(of_rays, 0.3);
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
