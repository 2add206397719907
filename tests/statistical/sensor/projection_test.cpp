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
TEST_P(Projection, ImportanceOfEveryPixelIntegratesToOne) {
  constexpr int kSamples = 1 << 20, kSeeds = 3, kGrid = 32;
  const auto pixels = static_cast<std::size_t>(sensor_.width * sensor_.height);
  std::vector<double> expected(pixels);
  for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
    for (int place = 0; place < kGrid * kGrid; place += kWidth) {
      alignas(64) float x[kWidth], y[kWidth];
      for (int l = 0; l < kWidth; ++l) {
        const auto column = static_cast<int>(pixel) % sensor_.width,
                   row = static_cast<int>(pixel) / sensor_.width;
        const auto part_x = (place + l) % kGrid, part_y = (place + l) / kGrid;
        x[l] = static_cast<float>(column) + (static_cast<float>(part_x) + 0.5f) / kGrid;
        y[l] = static_cast<float>(row) + (static_cast<float>(part_y) + 0.5f) / kGrid;
      }
      const SensorRay ray = start_ray(sensor_, middle_sample({Float::load(x), Float::load(y)}));
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
          connect_to_sensor(sensor_, p, {numbers(), numbers()}, Float(0.0f), Mask::all());
      const Float value = seen.importance * abs(dot(normalize(p - seen.lens), normal));
      for (int l = 0; l < kWidth; ++l) {
        const double column = std::floor(seen.raster.x.lane(l)), row = std::floor(seen.raster.y.lane(l));
        if (!(seen.valid.bits() >> l & 1) ||
            !(column >= 0 && column < sensor_.width && row >= 0 && row < sensor_.height))
          continue;
        const double of_sphere = value.lane(l) * 4 * pi * radius * radius;
        const auto pixel = static_cast<std::size_t>(row * sensor_.width + column);
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

INSTANTIATE_TEST_SUITE_P(Cameras, Projection, testing::ValuesIn(kCameras),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
