// A triangle seen from a point, sampled uniformly by solid angle [Arvo 1995]. Written with half angles and with sides
// of the flat triangle, where Arvo's formulas subtract angles: small triangles keep their digits.
#pragma once

#include "render/core/constants.h"
#include "render/sampling/solid_angle.h"

namespace tessera::render::TESSERA_ISA {

class SphericalTriangle {
 public:
  /// Corners relative to the point of view, none of them at it: `p0`, and `p0 + e1`, `p0 + e2`.
  TESSERA_INLINE SphericalTriangle(Vec3 p0, Vec3 e1, Vec3 e2)
      : p0_(p0), p1_(p0 + e1), e2_(e2), inverse0_(inverse_length(p0)), inverse1_(inverse_length(p1_)) {
    a_ = p0 * inverse0_;
    b_ = p1_ * inverse1_;
    const Vec3 p2 = p0 + e2;
    const Float inverse2 = inverse_length(p2);
    c_ = p2 * inverse2;
    across_b_ = cross(a_, e1 * inverse1_);
    across_c_ = cross(a_, e2 * inverse2);
    volume_ = abs(dot(across_b_, e2 * inverse2));
    const HalfSolidAngle half = half_solid_angle(a_, b_, c_, volume_);
    solid_angle_ = half.whole();
    precise_ = half.precise();
  }

  TESSERA_INLINE Float solid_angle() const { return solid_angle_; }
  /// solid_angle() is to be relied on, see HalfSolidAngle.
  TESSERA_INLINE Mask precise() const { return precise_; }
  /// Unit vectors to the corners.
  TESSERA_INLINE Vec3 to_corner0() const { return a_; }
  TESSERA_INLINE Vec3 to_corner1() const { return b_; }
  TESSERA_INLINE Vec3 to_corner2() const { return c_; }

  /// Barycentric weights of the corners 1 and 2 of a point whose direction is uniform within the triangle. u = (0, 0)
  /// and (1, 0) are corner 1, (0, 1) is corner 0 and (1, 1) corner 2.
  TESSERA_INLINE Vec2 sample(Vec2 u) const {
    // The point q of the side from corner 0 to corner 2 that cuts off the part u.x of the solid angle: from
    // tan(E / 2) = t_b t_c sin A / (1 + t_b t_c cos A), where t are tangents of half sides.
    const Float half = 0.5f * u.x * solid_angle_;
    const Float sin_half = sin(half), cos_half = cos(half);
    const Float tan_c = length(across_b_) / max(1.0f + dot(a_, b_), 1e-30f);
    const Float scale = length(across_b_) * length(across_c_);
    // sin and cos of the angle at corner 0, times `scale`.
    const Float sin_a = volume_, cos_a = dot(across_b_, across_c_);
    const Float denominator = tan_c * difference_of_products(sin_a, cos_half, cos_a, sin_half);
    const Float tan_q = min(sin_half * scale / max(denominator, 1e-37f), 1e15f);
    const Float inverse = 1.0f / fma(tan_q, tan_q, 1.0f);
    const Float r = along(inverse0_, a_, e2_, 2.0f * tan_q * inverse, (1.0f - tan_q) * (1.0f + tan_q) * inverse);

    // On the arc from corner 1 to q, 1 - cos of the angle is uniform.
    const Vec3 q = p0_ + e2_ * r, to_q = q - p1_;
    const Float x = u.y * one_minus_cos(q, to_q);
    const Float s = along(inverse1_, b_, to_q, safe_sqrt(x * (2.0f - x)), 1.0f - x);
    return {1.0f - s, s * r};
  }

  /// The u with which sample() gives a point with these weights.
  TESSERA_INLINE Vec2 invert(Vec2 barycentric) const {
    const Float s = max(1.0f - barycentric.x, 0.0f);
    const Float r = clamp(barycentric.y / max(s, 1e-30f), 0.0f, 1.0f);
    const Vec3 q = p0_ + e2_ * r, to_q = q - p1_;
    const Float inverse_q = inverse_length(q);
    const Float volume = abs(dot(across_b_, e2_)) * r * inverse_q;
    const Float part = half_solid_angle(a_, b_, q * inverse_q, volume).whole();
    const Vec3 w = p1_ + to_q * s;
    return {clamp(part / max(solid_angle_, 1e-37f), 0.0f, 1.0f),
            clamp(one_minus_cos(w, to_q * s) / max(one_minus_cos(q, to_q), 1e-37f), 0.0f, 1.0f)};
  }

 private:
  static TESSERA_INLINE Float inverse_length(Vec3 v) { return 1.0f / max(length(v), 1e-18f); }

  /// 1 - cos of the angle between corner 1 and `q`, which is corner 1 + `to_q`.
  TESSERA_INLINE Float one_minus_cos(Vec3 q, Vec3 to_q) const {
    const Float inverse = inverse_length(q);
    const Float cosine = dot(b_, q) * inverse;
    const Float sine_squared = length_squared(cross(b_, to_q * inverse));
    return select(cosine > 0.0f, sine_squared / (1.0f + cosine), 1.0f - cosine);
  }

  /// The t in [0, 1] for which p + t `side` is seen under the angle of this sine and cosine from p, which lies in
  /// `direction`, 1 / `inverse_distance` away.
  static TESSERA_INLINE Float along(Float inverse_distance, Vec3 direction, Vec3 side, Float sine, Float cosine) {
    const Vec3 relative = side * inverse_distance;
    const Float slope = length(cross(direction, relative)) * cosine - dot(direction, relative) * sine;
    return select(slope > 0.0f, min(sine / max(slope, 1e-37f), 1.0f), 1.0f);
  }

  Vec3 p0_, p1_, e2_;
  Float inverse0_, inverse1_;
  Vec3 a_, b_, c_;            // unit, to the corners
  Vec3 across_b_, across_c_;  // normals of the planes through corner 0 and the others
  Float volume_, solid_angle_;
  Mask precise_;
};

}  // namespace tessera::render::TESSERA_ISA
