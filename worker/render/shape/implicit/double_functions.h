// The functions of expressions on sixteen real numbers; interval.h and dual.h have the same for enclosures
// and for numbers with derivatives.
#pragma once

#include "expression/program.h"
#include "render/core/wide_double.h"

namespace tessera::render::TESSERA_ISA {

inline constexpr double kLeastLog = 1e-300;
inline constexpr double kLargestExp = 690;  // e^690 is still a number

/// Perlin's noise, the one of textures (color/noise.h), and its gradient; a scalar, for noise is rare.
struct NoisePoint {
  double value, gradient[3];
};
NoisePoint noise_at(const double (&p)[3]);
/// Bounds of the noise, of a derivative, and of a second derivative: from those of its weights (15/8 and
/// 10/sqrt(3)) and of differences between corners, whose slopes are at most 2.
inline constexpr double kNoiseBound = 2, kNoiseSlope = 6.7, kNoiseCurvature = 29;

/// a - 2 pi k, for the nearest whole number k; within 4.
TESSERA_INLINE Double within_turn(Double a) {
  constexpr double kTurn = 6.283185307179586, kTurnRest = 2.4492935982947064e-16;
  const Double turns = floor(fma(a, Double(1 / kTurn), Double(0.5)));
  const Double r = fma(-turns, Double(kTurnRest), fma(-turns, Double(kTurn), a));
  return min(max(r, Double(-4.0)), Double(4.0));
}

TESSERA_INLINE Double constant_like(Double, double value) { return Double(value); }
TESSERA_INLINE Double square_root(Double a) { return sqrt(max(a, Double(0.0))); }
inline Double sine(Double a) { return sin(within_turn(a)); }
inline Double cosine(Double a) { return cos(within_turn(a)); }
inline Double exponential(Double a) { return exp(min(max(a, Double(-kLargestExp)), Double(kLargestExp))); }
inline Double logarithm(Double a) { return log(max(a, Double(kLeastLog))); }
TESSERA_INLINE Double magnitude(Double a) { return abs(a); }
TESSERA_INLINE Double lesser(Double a, Double b) { return min(a, b); }
TESSERA_INLINE Double greater(Double a, Double b) { return max(a, b); }

inline Double whole_power(Double a, int n) {
  Double result(1.0), square = a;
  for (unsigned rest = static_cast<unsigned>(n < 0 ? -n : n); rest != 0; rest >>= 1) {
    if (rest & 1) result = result * square;
    square = square * square;
  }
  return n < 0 ? Double(1.0) / result : result;
}
inline Double any_power(Double a, Double b) {
  return select(a > Double(0.0), exponential(b * logarithm(a)), Double(0.0));
}

/// The noise at sixteen points; `gradient` may be null.
inline Double noise_of(Double x, Double y, Double z, Double* gradient) {
  alignas(64) double p[3][kWidth], value[kWidth], slope[3][kWidth];
  x.store(p[0]), y.store(p[1]), z.store(p[2]);
  for (int i = 0; i < kWidth; ++i) {
    const NoisePoint n = noise_at({p[0][i], p[1][i], p[2][i]});
    value[i] = n.value;
    for (int k = 0; k < 3; ++k) slope[k][i] = n.gradient[k];
  }
  for (int k = 0; gradient != nullptr && k < 3; ++k) gradient[k] = Double::load(slope[k]);
  return Double::load(value);
}
inline Double noise_of(Double x, Double y, Double z) { return noise_of(x, y, z, nullptr); }

// What derivatives are made of.
TESSERA_INLINE Double sign_of(Double a) { return select(a < Double(0.0), Double(-1.0), Double(1.0)); }
/// `a` where x < y, else `b`.
TESSERA_INLINE Double where_less(Double x, Double y, Double a, Double b) { return select(x < y, a, b); }
/// 1 / a, and 0 for numbers that are not above `least`: functions stand still there.
TESSERA_INLINE Double inverse_above(Double a, double least) {
  const DoubleMask moves = a > Double(least);
  return select(moves, Double(1.0) / select(moves, a, Double(1.0)), Double(0.0));
}

}  // namespace tessera::render::TESSERA_ISA
