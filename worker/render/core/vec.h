// Wide vectors, points and frames. A Vec3 is a point, a direction or a normal; the name of the variable says
// which.
#pragma once

#include "render/core/wide.h"

namespace tessera::render::TESSERA_ISA {

struct Vec2 {
  Float x, y;
};

struct Vec3 {
  Float x, y, z;
};

TESSERA_INLINE Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
TESSERA_INLINE Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
TESSERA_INLINE Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
TESSERA_INLINE Vec3 operator*(Vec3 a, Float s) { return {a.x * s, a.y * s, a.z * s}; }
TESSERA_INLINE Vec3 operator*(Float s, Vec3 a) { return a * s; }
/// a s + b, rounded once.
TESSERA_INLINE Vec3 fma(Vec3 a, Float s, Vec3 b) {
  return {fma(a.x, s, b.x), fma(a.y, s, b.y), fma(a.z, s, b.z)};
}
TESSERA_INLINE Float dot(Vec3 a, Vec3 b) { return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z)); }
TESSERA_INLINE Float length_squared(Vec3 a) { return dot(a, a); }
TESSERA_INLINE Float length(Vec3 a) { return sqrt(length_squared(a)); }
TESSERA_INLINE Vec3 cross(Vec3 a, Vec3 b) {
  return {difference_of_products(a.y, b.z, a.z, b.y), difference_of_products(a.z, b.x, a.x, b.z),
          difference_of_products(a.x, b.y, a.y, b.x)};
}
/// Unit length; the zero vector stays zero.
TESSERA_INLINE Vec3 normalize(Vec3 a) {
  const Float l = length(a);
  return a * (1.0f / select(l == 0.0f, 1.0f, l));
}
TESSERA_INLINE Vec3 abs(Vec3 a) { return {abs(a.x), abs(a.y), abs(a.z)}; }
TESSERA_INLINE Vec3 select(Mask m, Vec3 a, Vec3 b) {
  return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
}
/// `v` turned to the side of `reference`.
TESSERA_INLINE Vec3 face_forward(Vec3 v, Vec3 reference) {
  const Mask flip = dot(v, reference) < 0.0f;
  return select(flip, -v, v);
}

/// An orthonormal basis; z is the normal.
struct Frame {
  Vec3 x, y, z;

  TESSERA_INLINE Vec3 to_local(Vec3 v) const { return {dot(v, x), dot(v, y), dot(v, z)}; }
  TESSERA_INLINE Vec3 to_world(Vec3 v) const { return fma(z, v.z, fma(y, v.y, x * v.x)); }

  /// From a unit normal alone [Duff et al. 2017].
  static TESSERA_INLINE Frame from_normal(Vec3 n) {
    const Float sign = copysign(Float(1.0f), n.z);
    const Float a = -1.0f / (sign + n.z);
    const Float b = n.x * n.y * a;
    return {
        {fma(sign * a, sqr(n.x), Float(1.0f)), sign * b, -sign * n.x}, {b, fma(a, sqr(n.y), sign), -n.y}, n};
  }
  /// x along the part of `tangent` that is perpendicular to the unit normal; arbitrary where there is none.
  static TESSERA_INLINE Frame from_normal_tangent(Vec3 n, Vec3 tangent) {
    const Vec3 t = fma(-n, dot(n, tangent), tangent);
    const Float l2 = length_squared(t);
    const Mask usable = l2 > 1e-12f * length_squared(tangent);
    const Frame fallback = from_normal(n);
    const Vec3 x = select(usable, t * (1.0f / sqrt(select(usable, l2, 1.0f))), fallback.x);
    return {x, cross(n, x), n};
  }
};

// Local directions: the normal is (0, 0, 1).
TESSERA_INLINE Float cos_theta(Vec3 w) { return w.z; }
TESSERA_INLINE Float abs_cos_theta(Vec3 w) { return abs(w.z); }
TESSERA_INLINE Mask same_hemisphere(Vec3 a, Vec3 b) { return a.z * b.z > 0.0f; }

}  // namespace tessera::render::TESSERA_ISA
