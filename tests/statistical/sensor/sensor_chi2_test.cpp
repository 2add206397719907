// Cameras: rays against the density that a film implies, and the importance that light tracing uses against
// rays.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "render/sampling/warp.h"
#include "statistical/sensor/askew_sensors.h"
#include "support/kernel/chi2.h"
#include "support/kernel/random_lanes.h"

namespace tessera::render::TESSERA_ISA {
namespace {

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
