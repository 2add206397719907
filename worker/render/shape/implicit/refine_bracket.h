// Newton's method between signs that differ, along 16 lines.
#pragma once

#include "render/core/wide_double.h"
#include "render/shape/implicit/dual.h"

namespace tessera::render::TESSERA_ISA {

/// Where f is zero in [low, high], at whose ends the signs differ, to within `precision`; looked for from
/// `start`, which lies there. `f(s)` returns values, `f.with_slope(s)` values and derivatives. Real is Double
/// or Float.
template <class Real, class Function>
Real refine_bracket(const Function& f, Real low, Real high, Real start, Mask active, Real precision) {
  const Real at_low = f(low);
  Real s = start;
  constexpr int kMostSteps = 60;
  for (int i = 0; i < kMostSteps; ++i) {
    const Dual<Real, 1> there = f.with_slope(s);
    const auto before = at_low * there.value <= Real(0.0f);
    high = select(before, s, high);
    low = select(before, low, s);
    const Real newton = s - there.value / there.d[0];
    // At the root a step ends at an end of the bracket, or beyond it by a rounding. Other steps that leave
    // the bracket halve it.
    const auto usable = ((newton > low) & (newton < high)) | (abs(newton - s) <= precision);
    const Real next = select(usable, min(max(newton, low), high), (low + high) * Real(0.5f));
    const Mask moves = active & mask_of(abs(next - s) > precision);
    s = select(there.value == Real(0.0f), s, next);
    if (none(moves)) break;
  }
  return s;
}

/// The same from the middle.
template <class Function>
Double refine_bracket(const Function& f, Double low, Double high, Mask active, double precision = 0x1p-48) {
  return refine_bracket(f, low, high, (low + high) * Double(0.5), active, Double(precision));
}

}  // namespace tessera::render::TESSERA_ISA
