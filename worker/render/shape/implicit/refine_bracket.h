// Newton's method between signs that differ, along 16 lines.
#pragma once

#include "render/core/wide_double.h"
#include "render/shape/implicit/dual.h"

namespace tessera::render::TESSERA_ISA {

/// Where f is zero in [low, high], at whose ends the signs differ, to within `precision`. `f(s)` returns
/// values, `f.with_slope(s)` values and derivatives.
template <class Function>
Double refine_bracket(const Function& f, Double low, Double high, Mask active, double precision = 0x1p-48) {
  const Double at_low = f(low);
  Double s = (low + high) * Double(0.5);
  constexpr int kMostSteps = 60;
  for (int i = 0; i < kMostSteps; ++i) {
    const Dual<Double, 1> there = f.with_slope(s);
    const DoubleMask before = at_low * there.value <= Double(0.0);
    high = select(before, s, high);
    low = select(before, low, s);
    const Double newton = s - there.value / there.d[0];
    // At the root a step ends at an end of the bracket, or beyond it by a rounding. Other steps that leave
    // the bracket halve it.
    const DoubleMask usable = ((newton > low) & (newton < high)) | (abs(newton - s) <= Double(precision));
    const Double next = select(usable, min(max(newton, low), high), (low + high) * Double(0.5));
    const Mask moves = active & mask_of(abs(next - s) > Double(precision));
    s = select(there.value == Double(0.0), s, next);
    if (none(moves)) break;
  }
  return s;
}

}  // namespace tessera::render::TESSERA_ISA
