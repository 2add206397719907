// What probes read of the light that arrives at them.
#pragma once

#include "render/core/vec.h"
#include "render/sensor/sensor_record.h"

namespace tessera::render::TESSERA_ISA {

/// The probes of pixels; -1 where there is none.
Int probe_of_pixels(const SensorRecord& sensor, UInt x, UInt y, Mask active);

/// How a probe weighs radiance from a direction.
struct ProbeWeight {
  Float importance;  // factor of radiance over solid angle
  Float pdf;         // density with which rays of the sensor have the direction, by solid angle
};
/// `axis`: the probe's, or the normal of its surface there; `wi`: unit vectors, to where light comes from.
/// Not of kFarField, which sees one direction.
ProbeWeight weigh_at_probe(const ProbeRecord& probe, Vec3 axis, Vec3 wi);

}  // namespace tessera::render::TESSERA_ISA
