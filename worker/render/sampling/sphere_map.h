// The maps between the unit square of an image and all directions. (0, 0) is the image's upper left corner: u
// runs along rows, v down the columns.
#pragma once

#include "render/core/constants.h"
#include "render/core/vec.h"

namespace tessera::render::TESSERA_ISA {

/// Equal-area octahedral, +z in the middle of the square and -z at its corners [Clarberg 2008], oriented as
/// in pbrt-v4.
TESSERA_INLINE Vec3 direction_from_octahedral(Vec2 uv) {
  const Float u = 2.0f * uv.x - 1.0f, v = 2.0f * uv.y - 1.0f;
  const Float au = abs(u), av = abs(v);
  // Distance from the diagonal: positive in the upper hemisphere.
  const Float signed_distance = 1.0f - (au + av);
  const Float r = 1.0f - abs(signed_distance);
  const Float phi = kPi / 4 * select(r == 0.0f, Float(1.0f), (av - au) / select(r == 0.0f, 1.0f, r) + 1.0f);
  const Float z = copysign(1.0f - sqr(r), signed_distance);
  const Float sin_theta = r * safe_sqrt(2.0f - sqr(r));
  return {sin_theta * copysign(cos(phi), u), sin_theta * copysign(sin(phi), v), z};
}

/// The inverse; `w` is a unit vector. In [0, 1]^2.
TESSERA_INLINE Vec2 octahedral_from_direction(Vec3 w) {
  const Float ax = abs(w.x), ay = abs(w.y), az = abs(w.z);
  // 1 - |z| from the other two, which keep their digits near the poles.
  const Float r = sqrt((sqr(ax) + sqr(ay)) / (1.0f + az));
  const Float phi = atan2(ay, ax) * (2.0f / kPi);
  const Float av = phi * r, au = r - av;
  const Mask lower = w.z < 0.0f;
  const Float fu = select(lower, 1.0f - av, au), fv = select(lower, 1.0f - au, av);
  return {clamp(0.5f * (copysign(fu, w.x) + 1.0f), 0.0f, 1.0f),
          clamp(0.5f * (copysign(fv, w.y) + 1.0f), 0.0f, 1.0f)};
}

/// Latitude-longitude as in Mitsuba 3: +y at the top, the left and right edges at -z, a quarter of the way
/// along at +x. `sin_theta` is the sine of the angle to +y.
struct LatLong {
  Vec2 uv;
  Float sin_theta;
};

TESSERA_INLINE LatLong latlong_from_direction(Vec3 w) {
  const Float sin_theta = sqrt(sqr(w.x) + sqr(w.z));
  const Float turn = atan2(w.x, -w.z) * kInv2Pi;
  const Float u = select(turn < 0.0f, turn + 1.0f, turn);
  return {{clamp(u, 0.0f, 1.0f), clamp(atan2(sin_theta, w.y) * kInvPi, 0.0f, 1.0f)}, sin_theta};
}

TESSERA_INLINE Vec3 direction_from_latlong(Vec2 uv) {
  const Float phi = 2.0f * kPi * uv.x, theta = kPi * uv.y;
  const Float sin_theta = sin(theta);
  return {sin(phi) * sin_theta, cos(theta), -cos(phi) * sin_theta};
}

}  // namespace tessera::render::TESSERA_ISA
