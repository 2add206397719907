// Paths at boundaries whose index of refraction varies with the wavelength: the first of a path's wavelengths
// says where it goes. The others end there, and the first stands for all [Wilkie et al. 2014; pbrt-v4]: at
// rough boundaries before light is looked for, as densities there are those of the first wavelength; at
// smooth ones where the path is refracted, as all wavelengths are reflected to one direction. Once for each
// path: all ways to find a path from both of its ends agree on whether it has such a vertex.
#pragma once

#include "render/transport/vertex/path_state.h"
#include "render/transport/vertex/vertex.h"

namespace tessera::render::TESSERA_ISA {

/// Light of the first wavelength alone, in these lanes.
TESSERA_INLINE Spectrum first_alone(Mask lanes, Spectrum light) {
  for (int i = 1; i < kSpectrumLanes; ++i) light.c[i] = select(lanes, 0.0f, light.c[i]);
  return light;
}

/// Light of the first wavelength, standing for all, in these lanes.
TESSERA_INLINE Spectrum first_for_all(Mask lanes, Spectrum light) {
  light.c[0] = select(lanes, light.c[0] * static_cast<float>(kSpectrumLanes), light.c[0]);
  return first_alone(lanes, light);
}

/// Ends the other wavelengths of these paths, where that has not been done yet.
TESSERA_INLINE void end_other_wavelengths(Mask lanes, WidePath& path) {
  const Mask now = lanes & (path.dispersed == 0);
  if (none(now)) return;
  path.beta = first_for_all(now, path.beta);
  path.dispersed = select(now, Int(1), path.dispersed);
}

/// Lanes whose vertex disperses, but for smooth boundaries.
TESSERA_INLINE Mask disperses_roughly(const SceneTables& scene, const Vertex& v, Mask met) {
  if (!disperses(scene)) return Mask::none();
  const Mask smooth = and_not((v.at.flags & kAllDelta) != 0, (v.at.flags & kMixed) != 0);
  return and_not(met & ((v.at.flags & kDisperses) != 0), smooth);
}

/// Disperses the light that comes to the vertex, before light is looked for and before the path goes on.
TESSERA_INLINE void disperse_at(const SceneTables& scene, const Vertex& v, Mask met, WidePath& path) {
  if (disperses(scene)) end_other_wavelengths(disperses_roughly(scene, v, met), path);
}
/// Disperses the light that goes on from the vertex as sampled, its beta being that of the sample.
TESSERA_INLINE void disperse_along(const SceneTables& scene, const Vertex& v, const BsdfSample& sample,
                                   WidePath& next) {
  if (!disperses(scene)) return;
  const Mask refracted = sample.valid & sample.transmission & ((v.at.traits & kRefracts) != 0);
  end_other_wavelengths(and_not(refracted & ((v.at.flags & kDisperses) != 0), v.in_medium), next);
}

/// A factor of light that a path from the eye and one from a light have brought together: where both stand
/// for one wavelength, each has counted the others.
TESSERA_INLINE Float joined_factor(Int dispersed_eye, Int dispersed_light) {
  return select((dispersed_eye & dispersed_light) != 0, Float(1.0f / kSpectrumLanes), Float(1.0f));
}

}  // namespace tessera::render::TESSERA_ISA
