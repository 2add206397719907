// Directions from a point that meet a sphere.
#pragma once

#include "render/sampling/warp.h"

namespace tessera::render::TESSERA_ISA {

/// How a sphere looks from a point.
struct Cone {
  Vec3 axis;  // unit, to the centre; at the centre along z
  Float centre_distance;
  Float radius;
  Float clearance_squared;  // centre_distance^2 - radius^2
  Float one_minus_cos_max;  // 1 where it is not usable
  Mask usable;              // a sphere with a radius, seen from outside
};

TESSERA_INLINE Cone cone(Vec3 centre, Float radius, Vec3 reference, Mask active) {
  Cone c;
  c.radius = radius;
  const Vec3 to_centre = centre - reference;
  c.centre_distance = length(to_centre);
  c.clearance_squared = (c.centre_distance - c.radius) * (c.centre_distance + c.radius);
  c.usable = active & (c.radius > 0.0f) & (c.clearance_squared > 0.0f);
  const Mask apart = c.centre_distance > 0.0f;
  const Float inv = 1.0f / select(apart, c.centre_distance, 1.0f);
  c.axis = to_centre * inv;
  c.axis.z = select(apart, c.axis.z, 1.0f);
  // 1 - cos = sin^2 / (1 + cos) keeps its digits for small angles.
  const Float sin_squared = sqr(c.radius * inv);
  const Float cos_max = sqrt(max(c.clearance_squared, 0.0f)) * inv;
  c.one_minus_cos_max = select(c.usable, sin_squared / (1.0f + cos_max), 1.0f);
  return c;
}

/// A ray from the point that the sphere is seen from.
struct Chord {
  Vec3 wi;       // unit
  Float middle;  // distance along it of the point that is nearest to the centre
  Float half_length;

  /// Distance at which the ray enters the sphere, from outside: middle - half_length, written as a quotient
  /// because the two may be close.
  TESSERA_INLINE Float near_end(const Cone& c) const {
    return c.clearance_squared / max(middle + half_length, 1e-30f);
  }
  TESSERA_INLINE Float far_end() const { return middle + half_length; }
};

/// A direction within an angle of the axis, uniform by solid angle.
TESSERA_INLINE Chord sample_chord(const Cone& c, Float one_minus_cos_max, Vec2 u) {
  const Vec3 local = square_to_cone(u, one_minus_cos_max);
  const Float off_axis_squared = sqr(c.centre_distance) * (sqr(local.x) + sqr(local.y));
  return {Frame::from_normal(c.axis).to_world(local), c.centre_distance * local.z,
          safe_sqrt(sqr(c.radius) - off_axis_squared)};
}

}  // namespace tessera::render::TESSERA_ISA
