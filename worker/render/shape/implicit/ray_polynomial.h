// A polynomial along a ray, and its first root [-1, 1] by several methods.
#pragma once

#include <optional>

namespace tessera::render::TESSERA_ISA {

inline constexpr int kMaxRayDegree = 12;

/// sum c[i] s^i, for s from -1 to 1. What it stands for is known up to `error`, anywhere there: values within
/// it count as zero, so that a surface that is only touched (a double root) is met.
struct RayPolynomial {
  int degree = 0;
  double c[kMaxRayDegree + 1] = {};
  double error = 0;

  double operator()(double s) const {
    double value = c[degree];
    for (int i = degree; i-- > 0;) value = value * s + c[i];
    return value;
  }
  double slope(double s) const {
    double value = degree * c[degree];
    for (int i = degree; i-- > 1;) value = value * s + i * c[i];
    return value;
  }
};

/// Beyond all roots: there is none.
inline constexpr double kNoRoot = 2;

/// The root within [low, high], at whose ends the signs differ: Newton's method within a bracket that
/// shrinks.
double refine_root(const RayPolynomial& p, double low, double high);

/// The first root by halving intervals over which coefficients in Bernstein's basis bound the values
/// [Lane1981]: none is missed. With `any`, a number within an interval that has a root.
double first_root_by_intervals(const RayPolynomial& p, bool any);

/// The first root by Sturm's theorem: signs that change in a chain of remainders count roots, halves of the
/// interval are counted until the first root is alone [Sturm1829; Hanrahan1983]. Errors of the chain are
/// bounded as it is made: nothing where they leave a sign open. With `any`, a number within [-1, 1] as soon
/// as the count is above zero.
std::optional<double> certain_root_by_sturm(const RayPolynomial& p, bool any);
/// The same; intervals decide where signs are open.
double first_root_by_sturm(const RayPolynomial& p, bool any);

/// The least of the roots that Newton's method finds, each divided out before the next is sought. Roots are
/// missed, the nearest among them: for comparison.
double first_root_by_newton(const RayPolynomial& p);

}  // namespace tessera::render::TESSERA_ISA
