// Solid angles of triangles, exact to a few roundings however small they are.
#pragma once

#include "render/core/vec.h"

namespace tessera::render::TESSERA_ISA {

/// Half of a solid angle as the angle of a vector in the plane; (0, 0) for none.
struct HalfSolidAngle {
  Float cosine, sine;  // times the same factor

  /// To a part in 10^3 or better. Not where the point of view all but lies on the triangle or its outline.
  TESSERA_INLINE Mask precise() const { return (fma(cosine, cosine, sqr(sine)) > 1e-6f) & (sine > 0.0f); }
  TESSERA_INLINE Float whole() const { return 2.0f * atan2(sine, cosine); }
};

/// Half the solid angle of the triangle between three unit vectors [Van Oosterom & Strackee 1983]. `volume`
/// is |det(a, b, c)|: given apart, as the sides of small triangles are known better than their corners.
TESSERA_INLINE HalfSolidAngle half_solid_angle(Vec3 a, Vec3 b, Vec3 c, Float volume) {
  return {1.0f + dot(a, b) + dot(b, c) + dot(c, a), volume};
}

/// Sum for two triangles side by side.
TESSERA_INLINE HalfSolidAngle operator+(HalfSolidAngle a, HalfSolidAngle b) {
  return {difference_of_products(a.cosine, b.cosine, a.sine, b.sine),
          fma(a.sine, b.cosine, b.sine * a.cosine)};
}

}  // namespace tessera::render::TESSERA_ISA
