// Intervals that enclose all values of a function over an interval of its arguments [Moore1966]: every
// operation rounds outwards by more than its own roundings. Bounds stay within +-1e300.
#pragma once

#include "render/shape/implicit/double_functions.h"

namespace tessera::render::TESSERA_ISA {

struct Interval {
  Double low, high;

  Interval() = default;
  TESSERA_INLINE Interval(Double l, Double h) : low(l), high(h) {}
  TESSERA_INLINE explicit Interval(double x) : low(x), high(x) {}
};

inline constexpr double kEntire = 1e300;
TESSERA_INLINE Interval entire() { return {Double(-kEntire), Double(kEntire)}; }
TESSERA_INLINE Interval constant_like(const Interval&, double value) { return Interval(value); }

/// Widened by `relative` of each bound and by `absolute`; the least there is takes care of numbers near zero.
TESSERA_INLINE Interval outward(Double low, Double high, double relative = 0x1p-52, double absolute = 0) {
  const Double r(relative), a(absolute + 1e-305);
  return {max(low - fma(abs(low), r, a), Double(-kEntire)),
          min(high + fma(abs(high), r, a), Double(kEntire))};
}
TESSERA_INLINE Interval bounded(const Interval& a, double low, double high) {
  return {min(max(a.low, Double(low)), Double(high)), max(min(a.high, Double(high)), Double(low))};
}
TESSERA_INLINE Interval hull(const Interval& a, const Interval& b) {
  return {min(a.low, b.low), max(a.high, b.high)};
}
TESSERA_INLINE Interval select(DoubleMask m, const Interval& a, const Interval& b) {
  return {select(m, a.low, b.low), select(m, a.high, b.high)};
}
TESSERA_INLINE DoubleMask has_zero(const Interval& a) {
  return (a.low <= Double(0.0)) & (a.high >= Double(0.0));
}

TESSERA_INLINE Interval operator+(const Interval& a, const Interval& b) {
  return outward(a.low + b.low, a.high + b.high);
}
TESSERA_INLINE Interval operator-(const Interval& a) { return {-a.high, -a.low}; }
TESSERA_INLINE Interval operator-(const Interval& a, const Interval& b) {
  return outward(a.low - b.high, a.high - b.low);
}
TESSERA_INLINE Interval operator*(const Interval& a, const Interval& b) {
  const auto product = [](Double x, Double y) { return min(max(x * y, Double(-kEntire)), Double(kEntire)); };
  const Double p = product(a.low, b.low), q = product(a.low, b.high), r = product(a.high, b.low),
               s = product(a.high, b.high);
  return outward(min(min(p, q), min(r, s)), max(max(p, q), max(r, s)));
}
TESSERA_INLINE Interval inverse_of(const Interval& a) {
  const DoubleMask zero = has_zero(a);
  return select(zero, entire(),
                outward(Double(1.0) / select(zero, Double(1.0), a.high),
                        Double(1.0) / select(zero, Double(1.0), a.low)));
}
TESSERA_INLINE Interval operator/(const Interval& a, const Interval& b) {
  return select(has_zero(b), entire(), a * inverse_of(b));
}

TESSERA_INLINE Interval square_root(const Interval& a) {
  const Interval r = outward(square_root(a.low), square_root(a.high));
  return {max(r.low, Double(0.0)), r.high};
}
inline Interval exponential(const Interval& a) {
  const Interval r = outward(exponential(a.low), exponential(a.high), 0x1p-49);
  return {select(a.low > Double(-kLargestExp), max(r.low, Double(0.0)), Double(0.0)), r.high};
}
inline Interval logarithm(const Interval& a) {
  return outward(logarithm(a.low), logarithm(a.high), 0x1p-49, 0x1p-60);
}
TESSERA_INLINE Interval magnitude(const Interval& a) {
  const Double low = abs(a.low), high = abs(a.high);
  return {select(has_zero(a), Double(0.0), min(low, high)), max(low, high)};
}
TESSERA_INLINE Interval lesser(const Interval& a, const Interval& b) {
  return {min(a.low, b.low), min(a.high, b.high)};
}
TESSERA_INLINE Interval greater(const Interval& a, const Interval& b) {
  return {max(a.low, b.low), max(a.high, b.high)};
}

/// Sine (quarters = 0) or cosine (1) over `a`: values at the ends, and crests and troughs between them.
inline Interval wave(const Interval& a, int quarters) {
  constexpr double kTurn = 6.283185307179586;
  const Double at_low = quarters ? cosine(a.low) : sine(a.low),
               at_high = quarters ? cosine(a.high) : sine(a.high);
  // Whether k turns past `phase` lie within, or so close that rounding hides it.
  const Interval wide = outward(a.low, a.high, 0x1p-46, 0x1p-46);
  const auto passes = [&](double phase) {
    const auto turns = [phase](Double x) { return floor((x - Double(phase)) * Double(1 / kTurn)); };
    return turns(wide.high) > turns(wide.low);
  };
  const double crest = quarters ? 0 : kTurn / 4;
  const DoubleMask far = magnitude(a).high > Double(1e9);
  const Interval r = outward(min(at_low, at_high), max(at_low, at_high), 0, 0x1p-48);
  return bounded({select(passes(crest + kTurn / 2) | far, Double(-1.0), r.low),
                  select(passes(crest) | far, Double(1.0), r.high)},
                 -1, 1);
}
inline Interval sine(const Interval& a) { return wave(a, 0); }
inline Interval cosine(const Interval& a) { return wave(a, 1); }

inline Interval whole_power(const Interval& a, int n) {
  const int m = n < 0 ? -n : n;
  const Interval of = m % 2 ? a : magnitude(a);  // over which the power rises
  const auto power = [m](Double x) { return min(max(whole_power(x, m), Double(-kEntire)), Double(kEntire)); };
  Interval r = outward(power(of.low), power(of.high), (m + 1) * 0x1p-52);
  if (m % 2 == 0) r.low = max(r.low, Double(0.0));
  return n < 0 ? inverse_of(r) : r;
}
inline Interval any_power(const Interval& a, const Interval& b) {
  const Interval positive = exponential(b * logarithm(a));
  // Where the base may be 0 or below, so may the power; the largest is that of the base's upper end.
  const Interval top = exponential(b * logarithm(Interval(a.high, a.high)));
  const DoubleMask may_vanish = a.low <= Double(0.0);
  const Interval rising =
      select(b.low > Double(0.0), Interval(Double(0.0), top.high), Interval(Double(0.0), Double(kEntire)));
  const Interval r = select(may_vanish, rising, positive);
  return select(a.high <= Double(0.0), Interval(0.0), r);
}

/// The middle, and the sum of half the widths.
struct Middle {
  Double x, y, z, radius;
};
inline Middle middle_of(const Interval& x, const Interval& y, const Interval& z) {
  const Double half(0.5);
  const auto radius = [](const Interval& a, Double m) { return max(a.high - m, m - a.low); };
  Middle m{(x.low + x.high) * half, (y.low + y.high) * half, (z.low + z.high) * half, Double(0.0)};
  m.radius = radius(x, m.x) + radius(y, m.y) + radius(z, m.z);
  return m;
}
inline Interval around(Double value, Double radius, double growth, double bound) {
  const Double r = radius * Double(growth * (1 + 0x1p-40));
  return bounded(outward(value - r, value + r, 0x1p-46, 0x1p-46), -bound, bound);
}
inline Interval noise_of(const Interval& x, const Interval& y, const Interval& z, Interval* gradient) {
  const Middle m = middle_of(x, y, z);
  Double slope[3];
  const Double value = noise_of(m.x, m.y, m.z, slope);
  for (int k = 0; gradient != nullptr && k < 3; ++k)
    gradient[k] = around(slope[k], m.radius, kNoiseCurvature, kNoiseSlope);
  return around(value, m.radius, kNoiseSlope, kNoiseBound);
}
inline Interval noise_of(const Interval& x, const Interval& y, const Interval& z) {
  return noise_of(x, y, z, nullptr);
}

TESSERA_INLINE Interval sign_of(const Interval& a) {
  return {select(a.low >= Double(0.0), Double(1.0), Double(-1.0)),
          select(a.high < Double(0.0), Double(-1.0), Double(1.0))};
}
TESSERA_INLINE Interval where_less(const Interval& x, const Interval& y, const Interval& a,
                                   const Interval& b) {
  return select(x.high < y.low, a, select(y.high < x.low, b, hull(a, b)));
}
TESSERA_INLINE Interval inverse_above(const Interval& a, double least) {
  const DoubleMask above = a.low > Double(least), below = a.high <= Double(least);
  return select(above, inverse_of(select(above, a, Interval(1.0))), select(below, Interval(0.0), entire()));
}

}  // namespace tessera::render::TESSERA_ISA
