// Shared by sensors whose raster lies in a plane.
#pragma once

#include <algorithm>
#include <cmath>

#include "render/sensor/sensor.h"

namespace tessera::render::TESSERA_ISA {

inline Vec3 sensor_origin() { return {Float(0.0f), Float(0.0f), Float(0.0f)}; }

/// The area that a pixel has in the plane of the raster.
inline float pixel_area(const SensorRecord& sensor) { return std::abs(sensor.scale_x * sensor.scale_y); }
/// The longer side of a pixel there.
inline float pixel_step(const SensorRecord& sensor) {
  return std::max(std::abs(sensor.scale_x), std::abs(sensor.scale_y));
}

/// A connection of rays that cross the plane z = 1 of places under the cosine: all of one weight.
inline LocalConnection through_plane(const SensorRecord& sensor, Vec3 point, Vec2 place, Vec3 lens) {
  const Float distance_squared = length_squared(point - lens);
  const Float cosine = point.z / sqrt(distance_squared);
  const Float density = 1.0f / (distance_squared * cosine * cosine * cosine * pixel_area(sensor));
  return {place, lens, density, density};
}

}  // namespace tessera::render::TESSERA_ISA
