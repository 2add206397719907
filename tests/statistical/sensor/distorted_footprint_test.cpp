// Footprints of pixels of a distorted film follow the derivative of the distortion.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <ostream>
#include <string>
#include <utility>

#include "render/sensor/distortion.h"
#include "render/sensor/footprint.h"
#include "render/sensor/sensor.h"
#include "statistical/sensor/camera_messages.h"
#include "support/kernel/random_lanes.h"

namespace tessera::render::TESSERA_ISA {
namespace {

using test::kOpenCv;
using test::sensor_of;

struct DistortedCamera {
  const char* name;
  const char* text;
  float allowed = 0.01f;      // relative
  std::uint32_t width = 640;  // pixels of the film
};
void PrintTo(const DistortedCamera& camera, std::ostream* out) { *out << camera.name; }

constexpr std::uint32_t kFilmHeight = 320;

class DistortedFootprint : public testing::TestWithParam<DistortedCamera> {};

/// Area of a footprint on the plane across the ray.
Float area_of(const FootprintRecord& record, const SensorRay& ray) {
  TexturePoint point = TexturePoint::at({Float(0.5f), Float(0.5f)});
  point.p = fma(ray.direction, Float(5.0f), ray.origin);
  const Frame across = Frame::from_normal(ray.direction);
  set_footprint(record, ray.direction, across.x, across.y, point);
  return length(cross(point.dpdx, point.dpdy));
}

TEST_P(DistortedFootprint, IsLargerByTheAreaThatAPlaceSees) {
  const auto sensor = sensor_of(GetParam().text, {GetParam().width, kFilmHeight});
  ASSERT_TRUE(sensor.ok()) << sensor.status();
  const FootprintRecord distorted = footprint_of(*sensor, 0.5);
  FootprintRecord plain = distorted;
  plain.distortion = nullptr;
  RandomLanes numbers(3);
  float least = 1, most = 1;
  for (int i = 0; i < 200; ++i) {
    // A fifth of them in the corners.
    const Float part_x = numbers(), part_y = numbers();
    const auto wide = static_cast<float>(GetParam().width), high = static_cast<float>(kFilmHeight);
    constexpr float kCorner = 6;  // pixels
    const auto to_edge = [&](Float part, float size) {
      return select(part < 0.5f, part * (2 * kCorner), size - (1.0f - part) * (2 * kCorner));
    };
    const Vec2 raster =
        i % 5 == 0 ? Vec2{to_edge(part_x, wide), to_edge(part_y, high)} : Vec2{part_x * wide, part_y * high};
    const SensorRay ray = start_ray(*sensor, middle_sample(raster));
    const Vec2 place{fma(raster.x, Float(sensor->scale_x), Float(sensor->offset_x)),
                     fma(raster.y, Float(sensor->scale_y), Float(sensor->offset_y))};
    const Float expected = undistort(*sensor->distortion, place).area,
                found = area_of(distorted, ray) / area_of(plain, ray);
    for (int l = 0; l < kWidth; ++l) {
      if (!(ray.valid.bits() >> l & 1)) continue;
      least = std::min(least, expected.lane(l)), most = std::max(most, expected.lane(l));
      // Slopes are exact at the nodes of 64 x 64 cells, and linear in between: of an area that grows by a
      // factor of e over n cells, 1 / (8 n^2) each way, where n is 10 or more; beyond the film's edge they go
      // straight on, for eight times that. Maps are bilinear: areas jump from cell to cell of 40 x 20, which
      // their slopes smooth.
      EXPECT_NEAR(found.lane(l), expected.lane(l), GetParam().allowed * expected.lane(l))
          << raster.x.lane(l) << " " << raster.y.lane(l);
    }
  }
  // Else the test would not see a distortion that is left out.
  EXPECT_GT(std::max(most - 1, 1 - least), GetParam().allowed + 0.005f);
}
INSTANTIATE_TEST_SUITE_P(
    Cameras, DistortedFootprint,
    testing::Values(
        // A wide film would be folded at its corners.
        DistortedCamera{"OpenCv", kOpenCv, 0.01f, 480},
        DistortedCamera{"Pincushion", "perspective { fov_degrees: 60 } distortion { opencv { k1: 0.3 } }"},
        DistortedCamera{"OpenCvFisheye",
                        "fisheye { fov_degrees: 160 } distortion { opencv_fisheye { k1: 0.1 k2: -0.01 } }"},
        DistortedCamera{"Map", "orthographic { } distortion { map { image { path: 'map.pfm' } } }", 0.03f},
        DistortedCamera{"MapOfFisheye",
                        "fisheye { fov_degrees: 90 mapping: EQUISOLID } distortion { map { image { } } }",
                        0.03f}),
    [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
