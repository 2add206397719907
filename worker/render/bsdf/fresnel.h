// Reflectance of smooth boundaries for unpolarised light [Born & Wolf, Principles of Optics, 1.5 and 14.2].
#pragma once

#include "render/color/spectrum.h"
#include "render/core/vec.h"

namespace tessera::render::TESSERA_ISA {

struct DielectricFresnel {
  Float reflectance;  // 1 for total reflection
  Float eta_cos_t;    // eta times the cosine of the refracted direction; 0 for total reflection
};

/// A boundary between dielectrics. `cos_i` >= 0 is between the normal and a direction on its side; `eta` is
/// the index of the other side over that of this side.
TESSERA_INLINE DielectricFresnel fresnel_dielectric(Float cos_i, Float eta) {
  // eta^2 cos_t^2 by Snell's law; written so that eta = 1 gives exactly cos_i.
  const Float g2 = fma(eta - 1.0f, eta + 1.0f, sqr(cos_i));
  const Mask total = g2 <= 0.0f;
  const Float g = safe_sqrt(g2);
  const Float eta2_cos_i = sqr(eta) * cos_i;
  const Float parallel = (eta2_cos_i - g) / (eta2_cos_i + g);
  const Float perpendicular = (cos_i - g) / (cos_i + g);
  return {select(total, 1.0f, 0.5f * fma(parallel, parallel, sqr(perpendicular))), g};
}

/// The direction refracted at a boundary with unit normal `n`, for dot(w, n) = cos_i >= 0 and `fresnel` of
/// the same arguments. Not meaningful for total reflection.
TESSERA_INLINE Vec3 refract(Vec3 w, Vec3 n, Float cos_i, Float eta, DielectricFresnel fresnel) {
  return (n * (cos_i - fresnel.eta_cos_t) - w) * (1.0f / eta);
}

/// The boundary of a conductor with complex index eta + i k, seen from vacuum. `cos_i` >= 0.
TESSERA_INLINE Float fresnel_conductor(Float cos_i, Float eta, Float k) {
  // Beyond this nothing changes but the exponents, which would overflow.
  constexpr float kLargestIndex = 1e4f;
  constexpr float kTiny = 1e-30f;
  const Float eta2 = sqr(min(eta, kLargestIndex)), k2 = sqr(min(k, kLargestIndex));
  const Float cos2 = sqr(cos_i), sin2 = max(1.0f - cos2, 0.0f);
  // a + i b = sqrt((eta + i k)^2 - sin^2)
  const Float real = eta2 - k2 - sin2;
  const Float a2_plus_b2 = sqrt(fma(real, real, 4.0f * eta2 * k2));
  const Float a = safe_sqrt(0.5f * (a2_plus_b2 + real));
  const Float even_s = a2_plus_b2 + cos2, odd = 2.0f * a * cos_i;
  const Float perpendicular = (even_s - odd) / max(even_s + odd, kTiny);
  const Float even_p = fma(cos2, a2_plus_b2, sqr(sin2)), odd_p = odd * sin2;
  const Float parallel = perpendicular * (even_p - odd_p) / max(even_p + odd_p, kTiny);
  return max(0.5f * (perpendicular + parallel),
             0.0f);  // rounding may leave less than nothing at Brewster's angle
}

TESSERA_INLINE Spectrum fresnel_conductor(Float cos_i, Spectrum eta, Spectrum k) {
  Spectrum result;
  for (int i = 0; i < kSpectrumLanes; ++i) result.c[i] = fresnel_conductor(cos_i, eta.c[i], k.c[i]);
  return result;
}

/// The same along the normal.
TESSERA_INLINE Spectrum normal_reflectance(Spectrum eta, Spectrum k) {
  const Spectrum one(1.0f), k2 = k * k;
  return ((eta - one) * (eta - one) + k2) / ((eta + one) * (eta + one) + k2);
}

/// In `lanes`, where `k` holds a reflectance along the normal: eta = 1 and the k that have it [pbrt-v4].
TESSERA_INLINE void conductor_of_reflectance(Mask lanes, Spectrum& eta, Spectrum& k) {
  for (int c = 0; c < kSpectrumLanes; ++c) {
    const Float r = clamp(k.c[c], 0.0f, 0.9999f);
    eta.c[c] = select(lanes, Float(1.0f), eta.c[c]);
    k.c[c] = select(lanes, 2.0f * sqrt(r / (1.0f - r)), k.c[c]);
  }
}

}  // namespace tessera::render::TESSERA_ISA
