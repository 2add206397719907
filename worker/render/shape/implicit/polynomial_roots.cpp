#include "render/shape/implicit/polynomial_roots.h"

#include "render/shape/implicit/bernstein.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// A polynomial in s, times (middle + half s), plus another.
struct Series {
  Double c[kMaxRayDegree + 1];
  int degree = -1;  // zero

  void multiply(Double middle, Double half) {
    if (degree < 0) return;
    c[degree + 1] = c[degree] * half;
    for (int i = degree; i > 0; --i) c[i] = fma(c[i], middle, c[i - 1] * half);
    c[0] = c[0] * middle;
    ++degree;
  }
  void add(const Series& other) {
    for (int i = 0; i <= other.degree; ++i) c[i] = i > degree ? other.c[i] : c[i] + other.c[i];
    if (other.degree > degree) degree = other.degree;
  }
  void add(double value) {
    if (value == 0) return;
    c[0] = degree < 0 ? Double(value) : c[0] + Double(value);
    if (degree < 0) degree = 0;
  }
};

/// Lanes whose values have one sign all along, beyond doubt.
Mask lanes_without_roots(const ChordPolynomials& p) {
  const auto& basis = bernstein_table().of[p.degree];
  Double least(1e300), largest(-1e300);
  for (int k = 0; k <= p.degree; ++k) {
    Double b = p.c[0];
    for (int m = 1; m <= p.degree; ++m) b = fma(p.c[m], Double(basis[m][k]), b);
    least = min(least, b), largest = max(largest, b);
  }
  return mask_of((least > Double(p.error)) | (largest < Double(-p.error)));
}

}  // namespace

RayPolynomial ChordPolynomials::lane(int lane) const {
  RayPolynomial p;
  p.degree = degree;
  alignas(64) double values[kWidth];
  for (int i = 0; i <= degree; ++i) {
    c[i].store(values);
    p.c[i] = values[lane];
  }
  p.error = error;
  // Along a line it may be of lower degree.
  while (p.degree > 1 && p.c[p.degree] == 0) --p.degree;
  return p;
}

ChordPolynomials expand_along(const ImplicitRecord& surface, const ObjectChord& chord) {
  const Double half = (chord.end - chord.begin) * Double(0.5), middle = chord.begin + half;
  const Point3 m = chord.at(middle);
  const Point3& d = chord.direction.value;
  const Point3 h{d.x * half, d.y * half, d.z * half};
  const int n = surface.degree;
  const double* coefficient = surface.coefficients.data();
  Series sum;
  for (int i = n; i >= 0; --i) {
    sum.multiply(m.x, h.x);
    Series in_y;
    for (int j = n - i; j >= 0; --j) {
      in_y.multiply(m.y, h.y);
      Series in_z;
      for (int k = n - i - j; k >= 0; --k) {
        in_z.multiply(m.z, h.z);
        in_z.add(*coefficient++);
      }
      in_y.add(in_z);
    }
    sum.add(in_y);
  }
  ChordPolynomials result;
  result.degree = n;
  result.error = polynomial_error(surface);
  for (int i = 0; i <= n; ++i) result.c[i] = i <= sum.degree ? sum.c[i] : Double(0.0);

  return result;
}

Double first_polynomial_roots(const ImplicitRecord& surface, const ObjectChord& chord, bool any) {
  const ChordPolynomials polynomials = expand_along(surface, chord);
  const Mask open = and_not(chord.meets, lanes_without_roots(polynomials));
  alignas(64) double begin[kWidth], end[kWidth], roots[kWidth];
  chord.begin.store(begin);
  chord.end.store(end);
  Double(-1.0).store(roots);
  for (std::uint32_t bits = open.bits(); bits != 0; bits &= bits - 1) {
    const int lane = __builtin_ctz(bits);
    const RayPolynomial p = polynomials.lane(lane);
    const double s = surface.roots == ImplicitRoots::kNewton     ? first_root_by_newton(p)
                     : surface.roots == ImplicitRoots::kInterval ? first_root_by_intervals(p, any)
                                                                 : first_root_by_sturm(p, any);
    if (s <= 1) roots[lane] = begin[lane] + 0.5 * (s + 1) * (end[lane] - begin[lane]);
  }
  return Double::load(roots);
}

}  // namespace tessera::render::TESSERA_ISA
