// Cameras as scenes have them: connections of points against the rays that leave the film.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "render/sampling/warp.h"
#include "render/sensor/model/aperture.h"
#include "render/sensor/sensor.h"
#include "statistical/sensor/camera_messages.h"
#include "support/kernel/random_lanes.h"

namespace tessera::render::TESSERA_ISA {
namespace {

using std::numbers::pi;
using test::kOpenCv;

struct CameraCase {
  const char* name;
  const char* camera;
  FilmSize film = {40, 20};
};

const CameraCase kCameras[] = {
    {"Tilted",
     "perspective { fov_degrees: 60 lens_radius: 0.3 focal_distance: 3 tilt { x_degrees: -8 y_degrees: 5 "
     "focal_length: 0.9 } }"},
    {"TiltedBlades",
     "perspective { fov_degrees: 60 lens_radius: 0.3 focal_distance: 3 aperture { blades: 5 ratio: 1.5 } "
     "tilt { "
     "x_degrees: 12 focal_length: 1.1 } }"},
    {"OpenCv", kOpenCv, {40, 30}},
    {"OpenCvThinLens",
     "perspective { fov_degrees: 60 lens_radius: 0.2 focal_distance: 2 } distortion { opencv { k1: 0.2 k2: "
     "-0.05 p1: 0.01 } }"},
    {"OpenCvFisheye",
     "fisheye { fov_degrees: 140 } distortion { opencv_fisheye { k1: 0.03 k2: -0.01 k3: 0.002 k4: -0.0003 } "
     "}",
     {24, 20}},
    {"Polynomial", "fisheye { fov_degrees: 120 } distortion { polynomial { angle: [1.02, -0.01, 0.03] } }"},
    {"Map", "perspective { fov_degrees: 60 } distortion { map { image { path: 'map.pfm' } } }"},
    {"MapOfFisheye", "fisheye { fov_degrees: 90 mapping: EQUISOLID } distortion { map { image { } } }"},
    {"OffAxis",
     "perspective { fov_degrees: 60 lens_radius: 0.1 focal_distance: 3 } viewpoint { x: 0.3 y: -0.1 "
     "convergence_distance: 2 }"},
    {"ToeIn",
     "perspective { fov_degrees: 60 } viewpoint { x: 0.3 y: 0.2 axes: TOE_IN convergence_distance: 2 }"},
    {"EqualArea", "spherical { mapping: EQUAL_AREA_CYLINDRICAL }"},
    {"Panorama", "panorama { }"},
    {"PartOfAPanorama",
     "panorama { longitude_min_degrees: -50 longitude_max_degrees: 170 latitude_min_degrees: -60 "
     "latitude_max_degrees: 80 }"},
    {"LeftEye", "panorama { } viewpoint { x: -0.5 axes: PARALLEL }"},
    {"RightEyeConverged", "panorama { } viewpoint { x: 0.5 convergence_distance: 4 }"},
    {"EyeMerged",
     "panorama { } viewpoint { x: -0.7 convergence_distance: 3 pole_merge_from_degrees: 40 "
     "pole_merge_to_degrees: 70 }"},
    {"Cross", "cube_map { }", {40, 30}},
    {"VerticalCross", "cube_map { layout: VERTICAL_CROSS equiangular: true }", {24, 32}},
    {"Strip", "cube_map { layout: STRIP }", {60, 10}},
    {"Column", "cube_map { layout: COLUMN }", {10, 60}},
    {"Front", "cube_map { layout: FRONT equiangular: true }", {20, 20}},
};

class Projection : public testing::TestWithParam<CameraCase> {
 protected:
  void SetUp() override {
    auto sensor = test::sensor_of(GetParam().camera, GetParam().film);
    ASSERT_TRUE(sensor.ok()) << sensor.status();
    sensor_ = *std::move(sensor);
    width_ = static_cast<float>(sensor_.width), height_ = static_cast<float>(sensor_.height);
  }

  SensorRecord sensor_;
  float width_ = 0, height_ = 0;
};

TEST_P(Projection, ConnectionsLeadToWhereTheRayBegan) {
  RandomLanes numbers(11);
  int valid = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vec2 raster{numbers(0, width_), numbers(0, height_)}, u_lens{numbers(), numbers()};
    const SensorRay ray = start_ray(sensor_, {raster, u_lens, Float(0.0f)});
    const Vec3 point = fma(ray.direction, exp(numbers(0, 4)), ray.origin);
    const SensorConnection seen = connect_to_sensor(sensor_, point, u_lens, Float(0.0f), ray.valid);
    for (int l = 0; l < kWidth; ++l) {
      if (!(ray.valid.bits() >> l & 1)) continue;
      // Near a pole, all longitudes are close to each other. Pixels span up to 18 degrees.
      const double latitude = std::abs(std::asin(std::clamp<double>(ray.direction.y.lane(l), -1, 1)));
      if (edges_of(sensor_) == RasterEdges::kOverPole && latitude > 1.4) continue;
      ++valid;
      ASSERT_TRUE(seen.valid.bits() >> l & 1) << raster.x.lane(l) << ", " << raster.y.lane(l);
      ASSERT_NEAR(seen.raster.x.lane(l), raster.x.lane(l), 1e-3);
      ASSERT_NEAR(seen.raster.y.lane(l), raster.y.lane(l), 1e-3);
      ASSERT_NEAR(seen.lens.x.lane(l), ray.origin.x.lane(l), 1e-4);
      ASSERT_NEAR(seen.lens.y.lane(l), ray.origin.y.lane(l), 1e-4);
      ASSERT_NEAR(seen.lens.z.lane(l), ray.origin.z.lane(l), 1e-4);
    }
  }
  EXPECT_GT(valid, 1000);
}

/// All rays of a pixel cross a sphere about the sensor once: the integral of its importance over that is 1,
/// or the part of the pixel that sees anything.
void expect_importance_of_one(const SensorRecord& sensor) {
  constexpr int kSamples = 1 << 20, kSeeds = 3, kGrid = 32;
  const auto pixels = static_cast<std::size_t>(sensor.width * sensor.height);
  std::vector<double> expected(pixels);
  for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
    for (int place = 0; place < kGrid * kGrid; place += kWidth) {
      alignas(64) float x[kWidth], y[kWidth];
      for (int l = 0; l < kWidth; ++l) {
        const auto column = static_cast<int>(pixel) % sensor.width,
                   row = static_cast<int>(pixel) / sensor.width;
        const auto part_x = (place + l) % kGrid, part_y = (place + l) / kGrid;
        x[l] = static_cast<float>(column) + (static_cast<float>(part_x) + 0.5f) / kGrid;
        y[l] = static_cast<float>(row) + (static_cast<float>(part_y) + 0.5f) / kGrid;
      }
      const SensorRay ray = start_ray(sensor, middle_sample({Float::load(x), Float::load(y)}));
      expected[pixel] += std::popcount(ray.valid.bits()) / double{kGrid * kGrid};
    }
  }
  const double radius = 7;
  double log_of_all = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    std::vector<double> sum(pixels), squares(pixels);
    RandomLanes numbers(static_cast<std::uint64_t>(seed + 1));
    for (int i = 0; i < kSamples; i += kWidth) {
      const Vec3 normal = square_to_sphere({numbers(), numbers()}), p = normal * static_cast<float>(radius);
      const SensorConnection seen =
          connect_to_sensor(sensor, p, {numbers(), numbers()}, Float(0.0f), Mask::all());
      const Float value = seen.importance * abs(dot(normalize(p - seen.lens), normal));
      for (int l = 0; l < kWidth; ++l) {
        const double column = std::floor(seen.raster.x.lane(l)), row = std::floor(seen.raster.y.lane(l));
        if (!(seen.valid.bits() >> l & 1) ||
            !(column >= 0 && column < sensor.width && row >= 0 && row < sensor.height))
          continue;
        const double of_sphere = value.lane(l) * 4 * pi * radius * radius;
        const auto pixel = static_cast<std::size_t>(row * sensor.width + column);
        sum[pixel] += of_sphere, squares[pixel] += of_sphere * of_sphere;
      }
    }
    double chi2 = 0, seen_in_all = 0, expected_in_all = 0, squares_of_all = 0;
    int tested = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
      const double mean = sum[i] / kSamples, variance = (squares[i] / kSamples - mean * mean) / kSamples;
      seen_in_all += mean / static_cast<double>(pixels),
          expected_in_all += expected[i] / static_cast<double>(pixels);
      squares_of_all += squares[i] / kSamples / static_cast<double>(pixels * pixels);
      // A border within a pixel is known to the grid of its rays alone.
      if (expected[i] < 0.999) continue;
      ASSERT_GT(variance, 0) << i;
      chi2 += (mean - expected[i]) * (mean - expected[i]) / variance;
      ++tested;
    }
    ASSERT_GT(tested, 100);
    // Chi-square comes close to this normal distribution.
    const double z = (chi2 - tested) / std::sqrt(2.0 * tested);
    log_of_all += std::log(std::erfc(std::abs(z) / std::numbers::sqrt2));
    // Where importance is the same everywhere, rounding alone is left.
    const double error = std::sqrt(std::max(squares_of_all - seen_in_all * seen_in_all, 0.0) / kSamples);
    EXPECT_NEAR(seen_in_all, expected_in_all, 5 * error + 1e-4);
  }
  // [Fisher 1925]
  double p = 0, term = std::exp(log_of_all);
  for (int i = 0; i < kSeeds; term *= -log_of_all / ++i) p += term;
  EXPECT_GT(p, 1e-4);
}

TEST_P(Projection, ImportanceOfEveryPixelIntegratesToOne) { expect_importance_of_one(sensor_); }

INSTANTIATE_TEST_SUITE_P(Cameras, Projection, testing::ValuesIn(kCameras),
                         [](const auto& test) { return std::string(test.param.name); });

// ---------------------------------------------------------------- panoramas through a lens

const CameraCase kPanoramaLenses[] = {
    {"Round", "panorama { lens_radius: 0.8 focal_distance: 3 }"},
    {"Part",
     "panorama { longitude_min_degrees: -50 longitude_max_degrees: 170 latitude_min_degrees: -60 "
     "latitude_max_degrees: 80 lens_radius: 0.8 focal_distance: 20 }"},
    {"Blades",
     "panorama { lens_radius: 0.8 focal_distance: 3 aperture { blades: 3 blade_degrees: 20 ratio: 1.5 } }"},
    {"Wide", "panorama { lens_radius: 0.5 focal_distance: 9 aperture { ratio: 0.5 } }"},
    {"Picture",
     "panorama { lens_radius: 0.8 focal_distance: 3 aperture { ratio: 0.8 image { path: 'm.pfm' } } }"},
};

class PanoramaLens : public Projection {};

TEST_P(PanoramaLens, ImportanceOfEveryPixelIntegratesToOne) { expect_importance_of_one(sensor_); }

double dot64(Vec3 a, Vec3 b, int l) {
  return double{a.x.lane(l)} * b.x.lane(l) + double{a.y.lane(l)} * b.y.lane(l) +
         double{a.z.lane(l)} * b.z.lane(l);
}

/// Rays of a place and connections to it lead through one point of the sphere of focus, and through the lens
/// that is at right angles to the way there; both begin where they are nearest to the middle.
TEST_P(PanoramaLens, RaysMeetOnTheSphereOfFocus) {
  const float f = sensor_.focal_distance;
  const double widest =
      sensor_.lens ? radius_about(*sensor_.lens) * sensor_.lens_radius : sensor_.lens_radius;
  // The middle sample of a round lens is its middle; a picture's need not be.
  SensorRecord round = sensor_;
  round.lens = nullptr;
  RandomLanes numbers(13);
  const auto expect_focus = [&](Vec3 origin, Vec3 direction, Vec2 raster, int l) {
    const SensorRay middle = start_ray(round, middle_sample(raster));
    const Vec3 focus = middle.direction * Float(f);
    ASSERT_NEAR(dot64(origin, direction, l), 0, 1e-5);
    const double along = dot64(focus - origin, direction, l);
    const Vec3 met = fma(direction, Float(static_cast<float>(along)), origin), miss = met - focus;
    ASSERT_LT(std::sqrt(dot64(miss, miss, l)), 2e-5 * f + 1e-5);
    // Back to the plane of the lens.
    const Float to_lens = -dot(origin, middle.direction) / dot(direction, middle.direction);
    const Vec3 lens = fma(direction, to_lens, origin);
    ASSERT_LT(std::sqrt(dot64(lens, lens, l)), widest * (1 + 1e-5));
  };
  int joined = 0;
  for (int i = 0; i < 500; ++i) {
    const Vec2 raster{numbers(0, width_), numbers(0, height_)}, u_lens{numbers(), numbers()};
    const SensorRay ray = start_ray(sensor_, {raster, u_lens, Float(0.0f)});
    const Vec3 point = square_to_sphere({numbers(), numbers()}) * exp(numbers(0, 4));
    const SensorConnection seen = connect_to_sensor(sensor_, point, u_lens, Float(0.0f), Mask::all());
    const Vec3 way = normalize(point - seen.lens);
    for (int l = 0; l < kWidth; ++l) {
      if (ray.valid.bits() >> l & 1) expect_focus(ray.origin, ray.direction, raster, l);
      if (!(seen.valid.bits() >> l & 1)) continue;
      ++joined;
      expect_focus(seen.lens, way, seen.raster, l);
    }
  }
  EXPECT_GT(joined, 500);
}

/// The sample that square_to_disk_polar() maps to a point, in doubles.
test::Point2 square_of_disk(double radius, double angle) {
  const double turned = angle - 2 * pi * std::floor((angle + pi / 4) / (2 * pi));  // [-pi/4, 7 pi/4)
  const bool negative = turned >= 3 * pi / 4;
  const double side = negative ? -radius : radius, rest = negative ? turned - pi : turned;
  const bool a_wins = rest < pi / 4;
  const double other = side * (a_wins ? rest : pi / 2 - rest) / (pi / 4);
  return {((a_wins ? side : other) + 1) / 2, ((a_wins ? other : side) + 1) / 2};
}

/// Points of a ray are joined to it by the sample of its lens's distance from the middle, and its direction
/// about the way to the point; and the ray has the density of that connection, which weighs it against paths
/// that are joined.
TEST_P(PanoramaLens, RaysAreFoundByTheirConnections) {
  const float widest = sensor_.lens ? radius_about(*sensor_.lens) * sensor_.lens_radius : sensor_.lens_radius;
  const double f = sensor_.focal_distance;
  RandomLanes numbers(17);
  int compared = 0, lost = 0;
  for (int i = 0; i < 500; ++i) {
    const Vec2 raster{numbers(0, width_), numbers(0, height_)}, u_lens{numbers(), numbers()};
    const SensorRay ray = start_ray(sensor_, {raster, u_lens, Float(0.0f)});
    const Vec3 point = fma(ray.direction, exp(numbers(0, 3)), ray.origin);
    const Float along = density_of_rays(sensor_, point, ray.direction, u_lens, Float(0.0f), Mask::all());
    alignas(64) float u[kWidth], v[kWidth];
    for (int l = 0; l < kWidth; ++l) {
      // The lens's distance from the middle by that of the ray, which is f |l| over the slant.
      const double nearest = dot64(ray.origin, ray.origin, l);
      const double radius = std::sqrt(nearest * f * f / (f * f - nearest));
      const double x = point.x.lane(l), y = point.y.lane(l), z = point.z.lane(l);
      const double far = std::sqrt(x * x + y * y + z * z), level = std::hypot(x, z);
      // The lens's side of the ray is away from its direction, seen from the point.
      const double right = -(ray.direction.x.lane(l) * z - ray.direction.z.lane(l) * x) / level;
      const double up = -(ray.direction.y.lane(l) * level -
                          (ray.direction.x.lane(l) * x + ray.direction.z.lane(l) * z) * y / level) /
                        far;
      const test::Point2 sample = square_of_disk(radius / widest, std::atan2(up, right));
      u[l] = static_cast<float>(std::clamp(sample.x, 0.0, 0.9999999));
      v[l] = static_cast<float>(std::clamp(sample.y, 0.0, 0.9999999));
    }
    const SensorConnection seen =
        connect_to_sensor(sensor_, point, {Float::load(u), Float::load(v)}, Float(0.0f), Mask::all());
    for (int l = 0; l < kWidth; ++l) {
      const double latitude = std::abs(std::asin(std::clamp<double>(ray.direction.y.lane(l), -1, 1)));
      if (!(ray.valid.bits() >> l & 1) || latitude > 1.2) continue;
      ++compared;
      // On the edge of an aperture, a float may round to either side.
      if (!(seen.valid.bits() >> l & 1)) {
        ++lost;
        continue;
      }
      ASSERT_NEAR(seen.raster.x.lane(l), raster.x.lane(l), 2e-3);
      ASSERT_NEAR(seen.raster.y.lane(l), raster.y.lane(l), 2e-3);
      ASSERT_NEAR(seen.lens.x.lane(l), ray.origin.x.lane(l), 2e-4);
      ASSERT_NEAR(seen.lens.y.lane(l), ray.origin.y.lane(l), 2e-4);
      ASSERT_NEAR(seen.lens.z.lane(l), ray.origin.z.lane(l), 2e-4);
      // Brightness of a picture jumps from cell to cell.
      if (std::abs(along.lane(l) / seen.density.lane(l) - 1) > 2e-3) ++lost;
    }
  }
  EXPECT_GT(compared, 1000);
  EXPECT_LE(lost, compared / 200);
}

INSTANTIATE_TEST_SUITE_P(Cameras, PanoramaLens, testing::ValuesIn(kPanoramaLenses),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
