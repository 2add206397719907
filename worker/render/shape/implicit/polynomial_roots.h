// First roots of a polynomial surface along 16 rays.
#pragma once

#include <algorithm>
#include <cmath>

#include "render/shape/implicit/object_ray.h"
#include "render/shape/implicit/ray_polynomial.h"

namespace tessera::render::TESSERA_ISA {

/// Error that rounding may bring to a polynomial's value within the bounds, found by its expansion along a
/// ray. Each term goes through three roundings for each of 3 n multiplications at most, and as many of the
/// basis in which signs are told; a point of the ray is off by four roundings of the largest coordinate.
inline double polynomial_error(const ImplicitRecord& surface) {
  constexpr double kRounding = 0x1p-53;
  double reach = 0;
  for (int a = 0; a < 3; ++a)
    reach = std::max({reach, std::abs(double{surface.low[a]}), std::abs(double{surface.high[a]})});
  return kRounding * (12 * (surface.degree + 2) * surface.magnitude + 4 * surface.slope * reach);
}

/// The polynomial along each lane's part of its ray, which becomes [-1, 1]: expanded about the middle of that
/// part, however far away the ray begins. Coefficient i of lane l is c[i] of that lane.
struct ChordPolynomials {
  int degree;
  Double c[kMaxRayDegree + 1];
  double error;  // see RayPolynomial

  RayPolynomial lane(int i) const;
};
ChordPolynomials expand_along(const ImplicitRecord& surface, const ObjectChord& chord);

/// The ray parameter of the first root in each chord, or a negative number. With `any`, a number above 0
/// where there is one.
Double first_polynomial_roots(const ImplicitRecord& surface, const ObjectChord& chord, bool any);

}  // namespace tessera::render::TESSERA_ISA
