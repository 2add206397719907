// Light that is sent into a lens system from the scene, to become a ghost on its film.
#pragma once

#include "render/sensor/sensor.h"

namespace tessera::render::TESSERA_ISA {

/// Whether lights are to be sampled where they shine into the lens: the other half of what rays of the sensor
/// find whose SensorRay::pdf is above 0.
bool takes_light(const SensorRecord& sensor);

/// A place of the lens's outermost surface.
struct LensEntry {
  Vec3 point;               // render space
  Vec3 in_lens, in_normal;  // the same in the lens's own space, in millimetres; unit normal towards the scene
};
LensEntry sample_lens_entry(const SensorRecord& sensor, Vec2 u, Float time);

/// Where such light lands.
struct LensLanding {
  Vec2 raster;  // pixels from the upper left corner
  // Radiance over the density of its direction by solid angle, times this, is the light's part of a pixel
  // for a box filter of one pixel, where a pixel takes one sample and the lens as many as there are pixels.
  Float value;
  Vec3 tint;   // factors of red, green and blue besides; not of light of wavelengths
  Float pdf;   // SensorRay::pdf of the ray that goes the same way
  Mask valid;  // it lands on the plane of the film
};
/// Follows light that comes from the direction `wi`, of unit length in render space, to the film, over a
/// bounce that `u_bounce` chooses. `wavelength` in nanometres, with SensorRecord::disperses only.
LensLanding send_into_lens(const SensorRecord& sensor, const LensEntry& entry, Vec3 wi, Float u_bounce,
                           Float wavelength, Float time, Mask active);

}  // namespace tessera::render::TESSERA_ISA
