// The colour that the integrators carry, per lane of a wide value.
//
// A job renders either in linear Rec.709 (three components: R, G, B) or, one day, with four wavelengths.
// Which, only this folder knows; everything else multiplies and adds Spectrum values, and goes through
// spectrum_of() and band() to colours of tables and films and back. Kernels for RGB jobs carry three
// components [docs/architecture.md, deviations].
#pragma once

#include "render/color/bands.h"
#include "render/core/vec.h"
#include "render/core/wide.h"

#ifndef TESSERA_SPECTRUM_LANES
#define TESSERA_SPECTRUM_LANES 3
#endif

namespace tessera::render::TESSERA_ISA {

inline constexpr int kSpectrumLanes = TESSERA_SPECTRUM_LANES;
static_assert(kSpectrumLanes >= kBands);

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

/// The band of colours that a lane lies in; every band has one lane at least.
constexpr int band_of(int lane) { return lane * kBands / kSpectrumLanes; }

/// The spectrum of a colour with the components component(0), (1) and (2), the same throughout a band.
template <class F>
TESSERA_INLINE Spectrum spectrum_of(F&& component) {
  Spectrum r;
  for (int i = 0; i < kSpectrumLanes; ++i) r.c[i] = component(band_of(i));
  return r;
}
TESSERA_INLINE Spectrum spectrum_of(const float (&color)[kBands]) {
  return spectrum_of([&](int band) { return Float(color[band]); });
}

/// The component `band` of the colour of a spectrum whose lanes are lane(0) and so on: the mean over the
/// band.
template <class F>
TESSERA_INLINE auto band_mean(int band, F&& lane) {
  int first = 0;
  while (band_of(first) < band) ++first;
  int count = 1;
  auto sum = lane(first);
  for (int i = first + 1; i < kSpectrumLanes && band_of(i) == band; ++i, ++count) sum = sum + lane(i);
  return count == 1 ? sum : sum * (1.0f / static_cast<float>(count));
}
/// Red, green and blue.
TESSERA_INLINE Vec3 rgb_of(Spectrum a) {
  const auto component = [&](int band) { return band_mean(band, [&](int lane) { return a.c[lane]; }); };
  return {component(0), component(1), component(2)};
}

/// Luminance of linear Rec.709.
TESSERA_INLINE Float luminance(Float red, Float green, Float blue) {
  return 0.2126f * red + 0.7152f * green + 0.0722f * blue;
}
/// The same, with the digits of Mitsuba 3.
TESSERA_INLINE Float luminance(Spectrum a) {
  const Vec3 rgb = rgb_of(a);
  return 0.212671f * rgb.x + 0.715160f * rgb.y + 0.072169f * rgb.z;
}

}  // namespace tessera::render::TESSERA_ISA
