// The moments at which a sensor is exposed: times from 0 (the first of it is exposed) to 1 (the last of it).
#pragma once

#include "render/core/vec.h"
#include "render/sensor/sensor_record.h"

namespace tessera::render::TESSERA_ISA {

/// When a sample is taken, and what it counts for.
struct Exposure {
  Float time;
  Float weight;
};

/// The time of a sample of its own at `raster`, in pixels from the upper left corner: where `u` is uniform in
/// [0, 1), it has the density of the row's exposure.
Float time_at(const SensorRecord& sensor, Vec2 raster, Float u);

/// The time of paths that begin at lights, before it is known where the raster sees them.
Float time_of_light(const SensorRecord& sensor, Float u);

/// The density of time_at() at this time over that of time_of_light(): what a path that begins at a light
/// counts for at `raster`, and what a sample counts for that has its time from there. 1 unless rows are
/// exposed one after the other.
Float exposure_at(const SensorRecord& sensor, Vec2 raster, Float time);

/// A time for `group` samples each, a power of two, which are neighbours in the lanes: it has the mean of the
/// densities of time_at() for their places, over which each one's own is its weight. `u` is the number of the
/// first of each group.
Exposure exposure_of_groups(const SensorRecord& sensor, Vec2 raster, Float u, int group);

}  // namespace tessera::render::TESSERA_ISA
