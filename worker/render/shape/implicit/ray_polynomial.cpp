#include "render/shape/implicit/ray_polynomial.h"

#include <algorithm>
#include <cmath>

#include "render/core/wide.h"

namespace tessera::render::TESSERA_ISA {

double refine_root(const RayPolynomial& p, double low, double high) {
  const double at_low = p(low);
  if (at_low == 0) return low;
  double s = 0.5 * (low + high);
  constexpr int kMostSteps = 80;  // halving alone needs 54
  for (int i = 0; i < kMostSteps; ++i) {
    const double value = p(s);
    if (value == 0) return s;
    ((value > 0) == (at_low > 0) ? low : high) = s;
    const double newton = s - value / p.slope(s);
    // At the root a step ends at an end of the bracket, or beyond it by a rounding.
    if (std::abs(newton - s) <= 0x1p-50) return std::clamp(newton, low, high);
    // A step that leaves the bracket, or is not a number, halves it.
    const double next = newton > low && newton < high ? newton : 0.5 * (low + high);
    if (!(high - low > 0x1p-50)) return next;
    s = next;
  }
  return s;
}

double first_root_by_newton(const RayPolynomial& p) {
  RayPolynomial rest = p;
  double first = kNoRoot, start = -1;
  while (rest.degree > 0) {
    double s = start;
    bool found = false;
    for (int i = 0; i < 40 && !found; ++i) {
      const double step = rest(s) / rest.slope(s);
      if (!std::isfinite(step)) break;
      s -= step;
      found = std::abs(step) <= 1e-12 * (1 + std::abs(s));
    }
    if (!found) break;  // no real root is left, or the method circles
    if (s >= -1 && s <= 1 && s < first) first = s;
    // Horner's rule leaves the quotient by s - root.
    double carry = rest.c[rest.degree];
    for (int i = rest.degree; i-- > 0;) {
      const double next = rest.c[i] + s * carry;
      rest.c[i] = carry;
      carry = next;
    }
    --rest.degree;
  }
  return first;
}

}  // namespace tessera::render::TESSERA_ISA
