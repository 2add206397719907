// From colours of lights to the light that paths carry.
#pragma once

#include "render/color/spectra.h"
#include "render/integrator/scene_tables.h"
#include "render/light/light.h"

namespace tessera::render::TESSERA_ISA {

/// `color`, which the models of lights give, as it comes from light `light`, whose own curve it has if that
/// is known.
TESSERA_INLINE Spectrum spectrum_of_light(const SceneTables& scene, const Spectra& spectra, Int light,
                                          const Color& color, Mask active) {
  Int curve(-1);
  if (kSpectral && !scene.spectral->curve_of_light.empty())
    curve = gather(scene.spectral->curve_of_light.data(), light, active);
  return spectra.light(color, curve, active);
}

/// emitted_radiance() and environment_radiance() as paths carry it.
TESSERA_INLINE Spectrum emitted_light(const SceneTables& scene, const Spectra& spectra,
                                      const Surface& surface, Vec3 wo, Mask active) {
  return spectrum_of_light(scene, spectra, surface.light,
                           emitted_radiance(scene.lights, surface.light, surface, wo, active), active);
}
TESSERA_INLINE Spectrum environment_light(const SceneTables& scene, const Spectra& spectra,
                                          std::int32_t light, const Receiver& from, Vec3 wi, Mask active) {
  return spectrum_of_light(scene, spectra, Int(light),
                           environment_radiance(scene.lights, light, from, wi, active), active);
}

}  // namespace tessera::render::TESSERA_ISA
