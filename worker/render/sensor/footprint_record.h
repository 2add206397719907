// The part of a sensor that footprints need, as the kernels read it.
#pragma once

#include "render/sensor/sensor_record.h"

namespace tessera::render {

/// The sensor half-way through the exposure.
struct FootprintRecord {
  bool on = false;  // else textures are not filtered
  // Unit axes of the sensor (right, up, forward) and its place, render space.
  float x[3] = {1, 0, 0}, y[3] = {0, 1, 0}, z[3] = {0, 0, 1}, place[3] = {0, 0, 0};
  bool parallel = false;  // rays: `spread` is a length, else an angle in radians
  float spread_x = 0, spread_y = 0;
  /// Cosine of the angle to the axis up to which pixels of a flat raster become smaller.
  float least_cosine = 1;
  /// null: pixels are not distorted. The table is the sensor's, which outlives the record; places of its film
  /// are lengths along the axes over `units`.
  const DistortionTable* distortion = nullptr;
  SensorKind kind = SensorKind::kPinhole;
  float units_x = 1, units_y = 1;
};

/// `part`: of a pixel's width; 0: no footprints.
FootprintRecord footprint_of(const SensorRecord& sensor, double part);

}  // namespace tessera::render
