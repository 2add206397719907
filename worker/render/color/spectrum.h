// Colours and spectra, 16 lanes wide.
//
// Kernels are compiled for one of two ways to carry light. Those for RGB carry linear Rec.709, and a Spectrum
// is a Color. Those for wavelengths (TESSERA_SPECTRAL) carry the light of four wavelengths, which each path
// has for itself (wavelengths.h). Textures are colours in both.
#pragma once

#include "render/color/bands.h"
#include "render/core/vec.h"
#include "render/core/wide.h"

#ifdef TESSERA_SPECTRAL
#define TESSERA_SPECTRUM_LANES 4
#else
#define TESSERA_SPECTRUM_LANES 3
#endif

namespace tessera::render::TESSERA_ISA {

template <int N>
struct Components {
  static constexpr int kCount = N;
  Float c[N];

  Components() = default;
  TESSERA_INLINE explicit Components(Float all) {
    for (int i = 0; i < N; ++i) c[i] = all;
  }
  TESSERA_INLINE explicit Components(float all) : Components(Float(all)) {}

  TESSERA_INLINE Float max_component() const {
    Float result = c[0];
    for (int i = 1; i < N; ++i) result = max(result, c[i]);
    return result;
  }
  TESSERA_INLINE Float mean() const {
    Float result = c[0];
    for (int i = 1; i < N; ++i) result = result + c[i];
    return result * (1.0f / N);
  }
};

/// Red, green and blue.
using Color = Components<kBands>;

inline constexpr int kSpectrumLanes = TESSERA_SPECTRUM_LANES;
/// Whether its lanes are wavelengths.
inline constexpr bool kSpectral = kSpectrumLanes != kBands;
/// The light that a path carries, or a factor of it.
using Spectrum = Components<kSpectrumLanes>;

#define TESSERA_COMPONENTS_OP(op)                                              \
  template <int N>                                                             \
  TESSERA_INLINE Components<N> operator op(Components<N> a, Components<N> b) { \
    Components<N> r;                                                           \
    for (int i = 0; i < N; ++i) r.c[i] = a.c[i] op b.c[i];                     \
    return r;                                                                  \
  }                                                                            \
  template <int N>                                                             \
  TESSERA_INLINE Components<N> operator op(Components<N> a, Float b) {         \
    Components<N> r;                                                           \
    for (int i = 0; i < N; ++i) r.c[i] = a.c[i] op b;                          \
    return r;                                                                  \
  }                                                                            \
  template <int N>                                                             \
  TESSERA_INLINE Components<N> operator op(Components<N> a, float b) {         \
    return a op Float(b);                                                      \
  }
TESSERA_COMPONENTS_OP(+)
TESSERA_COMPONENTS_OP(-)
TESSERA_COMPONENTS_OP(*)
TESSERA_COMPONENTS_OP(/)
#undef TESSERA_COMPONENTS_OP

template <int N>
TESSERA_INLINE Components<N> operator*(Float a, Components<N> b) {
  return b * a;
}
template <int N>
TESSERA_INLINE Components<N>& operator+=(Components<N>& a, Components<N> b) {
  return a = a + b;
}
template <int N>
TESSERA_INLINE Components<N>& operator*=(Components<N>& a, Components<N> b) {
  return a = a * b;
}
template <int N>
TESSERA_INLINE Components<N>& operator*=(Components<N>& a, Float b) {
  return a = a * b;
}

template <int N>
TESSERA_INLINE Components<N> select(Mask m, Components<N> a, Components<N> b) {
  Components<N> r;
  for (int i = 0; i < N; ++i) r.c[i] = select(m, a.c[i], b.c[i]);
  return r;
}
template <int N>
TESSERA_INLINE Components<N> select_or_zero(Mask m, Components<N> a) {
  Components<N> r;
  for (int i = 0; i < N; ++i) r.c[i] = select_or_zero(m, a.c[i]);
  return r;
}
template <int N>
TESSERA_INLINE Components<N> lerp(Float t, Components<N> a, Components<N> b) {
  Components<N> r;
  for (int i = 0; i < N; ++i) r.c[i] = lerp(t, a.c[i], b.c[i]);
  return r;
}
template <int N>
TESSERA_INLINE Mask is_black(Components<N> a) {
  Mask black = a.c[0] == 0.0f;
  for (int i = 1; i < N; ++i) black &= a.c[i] == 0.0f;
  return black;
}
template <int N>
TESSERA_INLINE Mask is_finite(Components<N> a) {
  Mask finite = is_finite(a.c[0]);
  for (int i = 1; i < N; ++i) finite &= is_finite(a.c[i]);
  return finite;
}
template <int N>
TESSERA_INLINE Components<N> max(Components<N> a, float b) {
  Components<N> r;
  for (int i = 0; i < N; ++i) r.c[i] = max(a.c[i], b);
  return r;
}
template <int N>
TESSERA_INLINE Components<N> clamp(Components<N> a, float low, float high) {
  Components<N> r;
  for (int i = 0; i < N; ++i) r.c[i] = clamp(a.c[i], low, high);
  return r;
}

/// The colour with the components component(0), (1) and (2).
template <class F>
TESSERA_INLINE Color color_of(F&& component) {
  Color r;
  for (int i = 0; i < kBands; ++i) r.c[i] = component(i);
  return r;
}
TESSERA_INLINE Color color_of(const float (&color)[kBands]) {
  return color_of([&](int band) { return Float(color[band]); });
}
TESSERA_INLINE Vec3 vec3_of(const Color& color) { return {color.c[0], color.c[1], color.c[2]}; }

/// Luminance of linear Rec.709.
TESSERA_INLINE Float luminance(Float red, Float green, Float blue) {
  return 0.2126f * red + 0.7152f * green + 0.0722f * blue;
}
/// The same, with the digits of Mitsuba 3.
TESSERA_INLINE Float luminance(const Color& color) {
  return 0.212671f * color.c[0] + 0.715160f * color.c[1] + 0.072169f * color.c[2];
}

}  // namespace tessera::render::TESSERA_ISA
