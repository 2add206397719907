// Shared by sensors whose rays begin at one point and may go in any direction.
#pragma once

#include "render/sensor/model/flat_raster.h"

namespace tessera::render::TESSERA_ISA {

inline constexpr SensorModel::Traits kAboutPoint{.has_axis = false};

/// A connection of rays that are all of one weight. `places`: area of places that see one steradian in the
/// point's direction.
inline LocalConnection from_point(const SensorRecord& sensor, Vec3 point, Vec2 place, Float places) {
  const Float density = places / (max(length_squared(point), 1e-30f) * pixel_area(sensor));
  return {place, sensor_origin(), density, density};
}

}  // namespace tessera::render::TESSERA_ISA
