// Paths that begin at the sensor.
#pragma once

#include "render/sensor/sensor.h"
#include "render/transport/vertex/dispersion.h"
#include "render/transport/vertex/light_spectrum.h"

namespace tessera::render::TESSERA_ISA {

/// The throughput of a path that begins with this ray.
TESSERA_INLINE Spectrum carried_by(const SensorRay& ray) {
  Spectrum beta(ray.weight);
  if constexpr (!kSpectral) {
    beta.c[0] = beta.c[0] * ray.tint.x;
    beta.c[1] = beta.c[1] * ray.tint.y;
    beta.c[2] = beta.c[2] * ray.tint.z;
  }
  return beta;
}

/// Sixteen paths that leave the sensor with these samples, whose own wavelength is set here; their layer
/// state is 0. Where the lens disperses, only the first of their wavelengths goes on.
TESSERA_INLINE WidePath start_at_sensor(const SceneTables& scene, SensorSample sample,
                                        const Wavelengths& wavelengths, Int slot) {
  sample.wavelength = first_wavelength(wavelengths, sample.wavelength);
  const SensorRay ray = start_ray(scene.sensor, sample);
  WidePath path{.origin = ray.origin,
                .direction = ray.direction,
                .beta = carried_by(ray),
                .wavelengths = wavelengths,
                .pdf = ray.pdf,
                .roulette_scale = Float(1.0f),
                .slot = slot,
                .normal = ray.normal,
                .dispersed = Int(0),
                .time = sample.time,
                .reference = ray.origin,
                .medium = Int(scene.sensor.medium),
                .layer_state = Int(0)};
  if (kSpectral && scene.sensor.disperses) end_other_wavelengths(Mask::all(), path);
  return path;
}

}  // namespace tessera::render::TESSERA_ISA
