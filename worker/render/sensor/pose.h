// Where a sensor stands.
#pragma once

#include "render/core/affine.h"
#include "render/core/motion.h"
#include "render/sensor/sensor_record.h"

namespace tessera::render::TESSERA_ISA {

/// Sensor space to render space.
inline WideAffine pose_at(const SensorRecord& sensor, Float time) {
  if (sensor.steps.empty()) return broadcast(sensor.render_from_sensor);
  const auto segments = static_cast<std::int32_t>(sensor.steps.size()) - 1;
  return affine_at(sensor.steps.data(), Int(0), Int(segments), time, Mask::all()).map;
}

inline Vec3 place_of(const WideAffine& pose) { return {pose.m[3], pose.m[7], pose.m[11]}; }

/// Whether the sensor is anywhere but at the origin of render space.
inline bool is_elsewhere(const SensorRecord& sensor) {
  const float* m = sensor.render_from_sensor.m;
  return !sensor.steps.empty() || m[3] != 0 || m[7] != 0 || m[11] != 0;
}

}  // namespace tessera::render::TESSERA_ISA
