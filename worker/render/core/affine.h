// Applying affine maps to wide points: one map for all lanes, or a map a lane.
#pragma once

#include "render/core/affine_data.h"
#include "render/core/vec.h"

namespace tessera::render::TESSERA_ISA {

/// Rows of a 3x4 matrix, which may differ between lanes.
struct WideAffine {
  Float m[12];
};

TESSERA_INLINE WideAffine broadcast(const Affine& a) {
  WideAffine r;
  for (int i = 0; i < 12; ++i) r.m[i] = a.m[i];
  return r;
}
TESSERA_INLINE Vec3 transform_vector(const WideAffine& a, Vec3 v) {
  return {dot({a.m[0], a.m[1], a.m[2]}, v), dot({a.m[4], a.m[5], a.m[6]}, v),
          dot({a.m[8], a.m[9], a.m[10]}, v)};
}
TESSERA_INLINE Vec3 transform_point(const WideAffine& a, Vec3 p) {
  return transform_vector(a, p) + Vec3{a.m[3], a.m[7], a.m[11]};
}
/// Transforms a normal by the map whose *inverse* is `inverse`.
TESSERA_INLINE Vec3 transform_normal(const WideAffine& inverse, Vec3 n) {
  return {dot({inverse.m[0], inverse.m[4], inverse.m[8]}, n),
          dot({inverse.m[1], inverse.m[5], inverse.m[9]}, n),
          dot({inverse.m[2], inverse.m[6], inverse.m[10]}, n)};
}
/// Inverse of a map that is not singular.
inline WideAffine inverse(const WideAffine& a) {
  const Vec3 x{a.m[0], a.m[4], a.m[8]}, y{a.m[1], a.m[5], a.m[9]}, z{a.m[2], a.m[6], a.m[10]};
  const Vec3 yz = cross(y, z), zx = cross(z, x), xy = cross(x, y);
  const Float scale = 1.0f / dot(x, yz);
  WideAffine r;
  int i = 0;
  for (const Vec3& row : {yz * scale, zx * scale, xy * scale}) {
    r.m[i] = row.x, r.m[i + 1] = row.y, r.m[i + 2] = row.z;
    r.m[i + 3] = -dot(row, {a.m[3], a.m[7], a.m[11]});
    i += 4;
  }
  return r;
}
TESSERA_INLINE Vec3 transform_vector(const Affine& a, Vec3 v) { return transform_vector(broadcast(a), v); }
TESSERA_INLINE Vec3 transform_point(const Affine& a, Vec3 p) { return transform_point(broadcast(a), p); }
TESSERA_INLINE Vec3 transform_normal(const Affine& inverse, Vec3 n) {
  return transform_normal(broadcast(inverse), n);
}

}  // namespace tessera::render::TESSERA_ISA
