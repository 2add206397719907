// Smooth boundaries whose index varies with the wavelength. They reflect all wavelengths of a path to one
// direction, with the mean of their reflectances as the probability, and refract each to its own: a sample
// that is refracted goes where the first wavelength does, and has no light of the others (transport/vertex/
// dispersion.h takes it from them).
#pragma once

#include "render/bsdf/bsdf.h"
#include "render/bsdf/fresnel.h"

namespace tessera::render::TESSERA_ISA {

/// Whether some lane has such a boundary.
TESSERA_INLINE bool some_disperse(const BsdfParams& params) {
  return kSpectral && (params.some_flags & kDisperses) != 0;
}

/// Reflectance at each wavelength, for |cosine| with the normal, on the side where z < 0 in lanes `below`.
TESSERA_INLINE Spectrum reflectances(const BsdfParams& params, Float cosine, Mask below) {
  Spectrum result;
#ifdef TESSERA_SPECTRAL
  for (int i = 0; i < kSpectrumLanes; ++i) {
    const Float eta = params.etas.c[i];
    result.c[i] = fresnel_dielectric(cosine, select(below, 1.0f / eta, eta)).reflectance;
  }
#else
  result = Spectrum(fresnel_dielectric(cosine, params.scalars[slot::kEta]).reflectance);
#endif
  return result;
}

/// Light that passes straight: this part at each wavelength, times `tint`.
TESSERA_INLINE Passing passing_of(Spectrum part, Spectrum tint) {
  const Float probability = part.mean();
  return {probability, tint * part * (1.0f / max(probability, 1e-30f))};
}

}  // namespace tessera::render::TESSERA_ISA
