// Maps from the unit square to the shapes and directions that are sampled. Each keeps areas, so that strata
// of the square stay strata of the result; `u` is uniform in [0, 1)^2.
#pragma once

#include "render/core/constants.h"
#include "render/core/vec.h"

namespace tessera::render::TESSERA_ISA {

/// A point in polar coordinates.
struct Polar {
  Float radius;  // [0, 1)
  Float angle;   // [-pi/4, 7 pi/4)
};

/// Uniform over the unit disk [Shirley & Chiu 1997].
TESSERA_INLINE Polar square_to_disk_polar(Vec2 u) {
  const Float a = fma(u.x, Float(2.0f), Float(-1.0f)), b = fma(u.y, Float(2.0f), Float(-1.0f));
  const Mask a_wins = abs(a) > abs(b);
  const Float radius = select(a_wins, a, b), other = select(a_wins, b, a);
  const Float ratio = other / select(radius == 0.0f, 1.0f, radius);
  const Float angle = select(a_wins, kPi / 4 * ratio, fnma(ratio, Float(kPi / 4), Float(kPi / 2)));
  // A negative radius is the opposite direction.
  return {abs(radius), select(radius < 0.0f, angle + kPi, angle)};
}
TESSERA_INLINE Vec2 square_to_disk(Vec2 u) {
  const Polar p = square_to_disk_polar(u);
  return {p.radius * cos(p.angle), p.radius * sin(p.angle)};
}

/// Density cos(theta) / pi over the hemisphere around +z.
TESSERA_INLINE Vec3 square_to_cosine_hemisphere(Vec2 u) {
  const Vec2 d = square_to_disk(u);
  return {d.x, d.y, safe_sqrt(fnma(d.y, d.y, fnma(d.x, d.x, Float(1.0f))))};
}
TESSERA_INLINE Float cosine_hemisphere_pdf(Float cos_theta) { return max(cos_theta, 0.0f) * kInvPi; }

/// Uniform within the cone around +z whose half-angle has 1 - cosine `one_minus_cos_max`. Exact for narrow
/// cones.
TESSERA_INLINE Vec3 square_to_cone(Vec2 u, Float one_minus_cos_max) {
  const Float x = u.x * one_minus_cos_max;  // 1 - cos(theta)
  const Float sin_theta = safe_sqrt(x * (2.0f - x));
  const Float phi = 2.0f * kPi * u.y;
  return {sin_theta * cos(phi), sin_theta * sin(phi), 1.0f - x};
}
TESSERA_INLINE Float cone_pdf(Float one_minus_cos_max) { return kInv2Pi / one_minus_cos_max; }

/// Uniform over the sphere; density 1 / (4 pi).
TESSERA_INLINE Vec3 square_to_sphere(Vec2 u) { return square_to_cone(u, 2.0f); }

struct Barycentric {
  Float b0, b1, b2;
};

/// Uniform over a triangle [Heitz 2019].
TESSERA_INLINE Barycentric square_to_triangle(Vec2 u) {
  const Mask upper = u.y > u.x;
  const Float half = 0.5f * min(u.x, u.y);
  const Float b0 = select(upper, half, u.x - half);
  const Float b1 = select(upper, u.y - half, half);
  return {b0, b1, max(1.0f - b0 - b1, 0.0f)};
}

}  // namespace tessera::render::TESSERA_ISA
