// Beckmann's distribution of microfacets, for microfacet.h: slopes are normal variates, with standard
// deviations alpha / sqrt(2) [Beckmann & Spizzichino 1963; Walter et al. 2007].
#pragma once

#include "render/core/constants.h"
#include "render/core/vec.h"

namespace tessera::render::TESSERA_ISA {

/// To 1.5e-7 [Abramowitz & Stegun 1964, 7.1.26].
TESSERA_INLINE Float erf(Float x) {
  const Float a = abs(x), t = 1.0f / fma(Float(0.3275911f), a, Float(1.0f));
  Float p(1.061405429f);
  for (const float c : {-1.453152027f, 1.421413741f, -0.284496736f, 0.254829592f}) p = fma(p, t, Float(c));
  return copysign(1.0f - p * t * exp(-sqr(a)), x);
}

/// For |x| < 1; to 3e-7 relative [Giles 2010].
TESSERA_INLINE Float erf_inverse(Float x) {
  const Float w = -log((1.0f - x) * (1.0f + x));
  const Float near = w - 2.5f, far = sqrt(max(w, 5.0f)) - 3.0f;
  Float p(2.81022636e-08f);
  for (const float c : {3.43273939e-07f, -3.5233877e-06f, -4.39150654e-06f, 0.00021858087f, -0.00125372503f,
                        -0.00417768164f, 0.246640727f, 1.50140941f}) {
    p = fma(p, near, Float(c));
  }
  const Mask tail = w >= 5.0f;
  if (any(tail)) {
    Float q(-0.000200214257f);
    for (const float c : {0.000100950558f, 0.00134934322f, -0.00367342844f, 0.00573950773f, -0.0076224613f,
                          0.00943887047f, 1.00167406f, 2.83297682f}) {
      q = fma(q, far, Float(c));
    }
    p = select(tail, q, p);
  }
  return p * x;
}

/// D of the direction of `h`, of any length.
TESSERA_INLINE Float beckmann_density(Vec3 h, Float alpha_x, Float alpha_y) {
  constexpr float kTiny = 1e-20f;
  constexpr float kNegligible = 60.0f;  // exp(-60) = 9e-27
  const Float z2 = max(sqr(h.z), kTiny);
  const Float slope2 = (sqr(h.x / alpha_x) + sqr(h.y / alpha_y)) / z2;
  const Float density =
      kInvPi * exp(-min(slope2, kNegligible)) * sqr(length_squared(h) / z2) / (alpha_x * alpha_y);
  return select_or_zero(slope2 < kNegligible, density);
}

/// Microfacets::masking_length of a direction with cosine `z` whose tangential part has the stretched length
/// `slope`. The rational function of [Walter et al. 2007] approximates G1 to 0.35 %, and so does all that
/// follows from it: values, densities, and what Mitsuba 3 renders.
TESSERA_INLINE Float beckmann_masking_length(Float z, Float slope) {
  constexpr float kUnmasked = 1.6f;  // G1 = 1 from here on
  const Float a = z / max(slope, 1e-30f);
  // G1 = a (c1 + c2 a) / (1 + c3 a + c4 a^2) and s = z (2 / G1 - 1), where z / a = slope.
  const Float b = min(a, kUnmasked);
  const Float numerator = fma(fma(Float(2.577f), b, Float(2.276f)), b, Float(1.0f));
  const Float masked = 2.0f * slope * numerator / fma(Float(2.181f), b, Float(3.535f)) - z;
  return select(a < kUnmasked, masked, z);
}

/// A slope of the surface stretched to alpha = 1, seen from the unit direction `w`; its normal is (-x, -y,
/// 1). Sampled as [Heitz & d'Eon 2014] say, with the numerical inversion of [Jakob 2014].
TESSERA_INLINE Vec2 beckmann_visible_slope(Vec3 w, Vec2 u) {
  constexpr float kInvSqrtPi = 0.56418958354776f;
  constexpr float kMargin = 1e-6f;
  const Float sine = sqrt(sqr(w.x) + sqr(w.y)), inverse = 1.0f / max(sine, 1e-20f);
  // Along w's azimuth slopes x have density (cos - x sin) exp(-x^2) up to x = cot. In v = erf(x) its integral
  // is cos (1 + v) + sin / sqrt(pi) exp(-x^2): increasing and concave, so that Newton's method converges from
  // below. It begins with the solution for grazing directions.
  const Float u_x = clamp(u.x, kMargin, 1.0f - kMargin);
  const Float cot = w.z * inverse, highest = min(erf(cot), 1.0f - 0x1p-23f);
  const auto integral = [&](Float v, Float x) {
    return fma(w.z, 1.0f + v, kInvSqrtPi * sine * exp(-sqr(x)));
  };
  const Float target = u_x * integral(highest, cot);
  Float v = highest - (highest + 1.0f) * erf(sqrt(-log(u_x)));
  for (int step = 0; step < 4; ++step) {
    v = clamp(v, -1.0f + kMargin * 0.25f, 1.0f - kMargin * 0.25f);
    const Float x = erf_inverse(v);
    const Float slope = max(w.z - x * sine, 1e-7f);
    v = v - (integral(v, x) - target) / slope;
  }
  v = min(max(v, -1.0f + kMargin * 0.25f), highest);
  const Float x = erf_inverse(v),
              y = erf_inverse(clamp(fma(Float(2.0f), u.y, Float(-1.0f)), -1.0f + kMargin, 1.0f - kMargin));
  // Turned to w's azimuth.
  const Mask upright = sine < 1e-10f;
  const Float cos_phi = select(upright, 1.0f, w.x * inverse), sin_phi = select(upright, 0.0f, w.y * inverse);
  return {cos_phi * x - sin_phi * y, sin_phi * x + cos_phi * y};
}

}  // namespace tessera::render::TESSERA_ISA
