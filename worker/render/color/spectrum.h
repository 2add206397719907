// The colour that the integrators carry, per lane of a wide value.
//
// A job renders either in linear Rec.709 (three components: R, G, B) or, one day, with four wavelengths.
// Which, only this folder knows; everything else multiplies and adds Spectrum values. Kernels for RGB jobs
// carry three components [docs/architecture.md, deviations].
#pragma once

#include "render/core/wide.h"

namespace tessera::render::TESSERA_ISA {

inline constexpr int kSpectrumLanes = 3;

struct Spectrum {
  Float c[kSpectrumLanes];

  Spectrum() = default;
  TESSERA_INLINE explicit Spectrum(Float all) {
    for (int i = 0; i < kSpectrumLanes; ++i) c[i] = all;
  }
  TESSERA_INLINE explicit Spectrum(float all) : Spectrum(Float(all)) {}

  TESSERA_INLINE Float max_component() const {
    Float result = c[0];
    for (int i = 1; i < kSpectrumLanes; ++i) result = max(result, c[i]);
    return result;
  }
  TESSERA_INLINE Float mean() const {
    Float result = c[0];
    for (int i = 1; i < kSpectrumLanes; ++i) result = result + c[i];
    return result * (1.0f / kSpectrumLanes);
  }
};

#define TESSERA_SPECTRUM_OP(op)                                         \
  TESSERA_INLINE Spectrum operator op(Spectrum a, Spectrum b) {         \
    Spectrum r;                                                         \
    for (int i = 0; i < kSpectrumLanes; ++i) r.c[i] = a.c[i] op b.c[i]; \
    return r;                                                           \
  }                                                                     \
  TESSERA_INLINE Spectrum operator op(Spectrum a, Float b) {            \
    Spectrum r;                                                         \
    for (int i = 0; i < kSpectrumLanes; ++i) r.c[i] = a.c[i] op b;      \
    return r;                                                           \
  }                                                                     \
  TESSERA_INLINE Spectrum operator op(Spectrum a, float b) { return a op Float(b); }
TESSERA_SPECTRUM_OP(+)
TESSERA_SPECTRUM_OP(-)
TESSERA_SPECTRUM_OP(*)
TESSERA_SPECTRUM_OP(/)
#undef TESSERA_SPECTRUM_OP

TESSERA_INLINE Spectrum operator*(Float a, Spectrum b) { return b * a; }
TESSERA_INLINE Spectrum& operator+=(Spectrum& a, Spectrum b) { return a = a + b; }
TESSERA_INLINE Spectrum& operator*=(Spectrum& a, Spectrum b) { return a = a * b; }
TESSERA_INLINE Spectrum& operator*=(Spectrum& a, Float b) { return a = a * b; }

TESSERA_INLINE Spectrum select(Mask m, Spectrum a, Spectrum b) {
  Spectrum r;
  for (int i = 0; i < kSpectrumLanes; ++i) r.c[i] = select(m, a.c[i], b.c[i]);
  return r;
}
TESSERA_INLINE Spectrum select_or_zero(Mask m, Spectrum a) {
  Spectrum r;
  for (int i = 0; i < kSpectrumLanes; ++i) r.c[i] = select_or_zero(m, a.c[i]);
  return r;
}
TESSERA_INLINE Spectrum lerp(Float t, Spectrum a, Spectrum b) {
  Spectrum r;
  for (int i = 0; i < kSpectrumLanes; ++i) r.c[i] = lerp(t, a.c[i], b.c[i]);
  return r;
}
TESSERA_INLINE Mask is_black(Spectrum a) {
  Mask black = a.c[0] == 0.0f;
  for (int i = 1; i < kSpectrumLanes; ++i) black &= a.c[i] == 0.0f;
  return black;
}
TESSERA_INLINE Mask is_finite(Spectrum a) {
  Mask finite = is_finite(a.c[0]);
  for (int i = 1; i < kSpectrumLanes; ++i) finite &= is_finite(a.c[i]);
  return finite;
}
TESSERA_INLINE Spectrum max(Spectrum a, float b) {
  Spectrum r;
  for (int i = 0; i < kSpectrumLanes; ++i) r.c[i] = max(a.c[i], b);
  return r;
}
TESSERA_INLINE Spectrum clamp(Spectrum a, float low, float high) {
  Spectrum r;
  for (int i = 0; i < kSpectrumLanes; ++i) r.c[i] = clamp(a.c[i], low, high);
  return r;
}

}  // namespace tessera::render::TESSERA_ISA
