// A rectangle seen from a point, sampled uniformly by solid angle [Urena, Fajardo & King 2013].
#pragma once

#include "render/core/constants.h"
#include "render/sampling/solid_angle.h"

namespace tessera::render::TESSERA_ISA {

class SphericalRectangle {
 public:
  /// `corner` is relative to the point of view; `x` and `y` are the unit vectors along the sides from it,
  /// which are at right angles, `normal` the one across.
  TESSERA_INLINE SphericalRectangle(Vec3 corner, Vec3 x, Vec3 y, Vec3 normal, Float width, Float height)
      : width_(width),
        height_(height),
        x0_(dot(corner, x)),
        y0_(dot(corner, y)),
        z_(abs(dot(corner, normal))) {
    y1_ = y0_ + height_;
    const Corners whole(x0_, x0_ + width_, y0_, y1_, z_);
    for (int i = 0; i < 4; ++i) inverse_[i] = whole.inverse[i];
    const HalfSolidAngle half = whole.half_solid_angle_of(width_, height_, z_);
    solid_angle_ = half.whole();
    precise_ = half.precise();
  }

  TESSERA_INLINE Float solid_angle() const { return solid_angle_; }
  /// solid_angle() is to be relied on, see HalfSolidAngle.
  TESSERA_INLINE Mask precise() const { return precise_; }
  /// 1 / distance of the corners: the one given, the others going round by way of x.
  TESSERA_INLINE Float inverse_distance(int corner) const { return inverse_[corner]; }

  /// Parts of the sides at which a direction meets the rectangle that is uniform within it. The relative
  /// error is about 1e-6 over the solid angle.
  TESSERA_INLINE Vec2 sample(Vec2 u) const {
    // z components of the normals of the planes through the sides, which point away; angles between two of
    // them.
    const Float x1 = x0_ + width_;
    const Float n0 = -y0_ / distance(y0_, z_), n2 = y1_ / distance(y1_, z_), n3 = -x0_ / distance(x0_, z_);
    const Float g2 = acos(clamp(-n2 * n3, -1.0f, 1.0f)), g3 = acos(clamp(-n3 * n0, -1.0f, 1.0f));
    const Float angle = fma(u.x, solid_angle_, 2.0f * kPi - (g2 + g3));
    const Float sine = sin(angle);
    const Float f = fma(cos(angle), n0, -n2) / select(sine == 0.0f, 1e-30f, sine);
    // tan of the direction's angle in the plane of x and z, of which c is the sine.
    const Float c_inverse_squared = fma(f, f, sqr(n0));
    const Float tangent = 1.0f / max(safe_sqrt(c_inverse_squared - 1.0f), 1e-18f);
    const Float x = min(max(copysign(z_ * tangent, f), x0_), x1);

    const Float d = distance(x, z_);
    const Float h = lerp(u.y, y0_ / distance(y0_, d), y1_ / distance(y1_, d));
    const Float y = min(max(h * d / max(safe_sqrt(fma(-h, h, 1.0f)), 1e-18f), y0_), y1_);
    return {clamp((x - x0_) / max(width_, 1e-37f), 0.0f, 1.0f),
            clamp((y - y0_) / max(height_, 1e-37f), 0.0f, 1.0f)};
  }

  /// The u with which sample() gives a point.
  TESSERA_INLINE Vec2 invert(Vec2 part) const {
    const Float x = part.x * width_;
    const Float d = distance(x0_ + x, z_);
    const Float y = fma(part.y, height_, y0_);
    const Float h0 = y0_ / distance(y0_, d), h1 = y1_ / distance(y1_, d);
    return {clamp(solid_angle_up_to(x) / max(solid_angle_, 1e-37f), 0.0f, 1.0f),
            clamp((y / distance(y, d) - h0) / max(h1 - h0, 1e-37f), 0.0f, 1.0f)};
  }

 private:
  static TESSERA_INLINE Float distance(Float a, Float b) { return max(sqrt(fma(a, a, b * b)), 1e-18f); }

  /// Unit vectors to the corners of a rectangle, and the inverses of their distances.
  struct Corners {
    Vec3 w[4];
    Float inverse[4];

    TESSERA_INLINE Corners(Float x0, Float x1, Float y0, Float y1, Float z)
        : w{{x0, y0, z}, {x1, y0, z}, {x1, y1, z}, {x0, y1, z}} {
      for (int i = 0; i < 4; ++i) {
        inverse[i] = 1.0f / max(length(w[i]), 1e-18f);
        w[i] = w[i] * inverse[i];
      }
    }
    TESSERA_INLINE HalfSolidAngle half_solid_angle_of(Float width, Float height, Float z) const {
      // Both triangles have the same volume, but for the distance of the corner that is theirs alone.
      const Float volume = width * inverse[0] * (height * inverse[2]) * z;
      return half_solid_angle(w[0], w[1], w[2], volume * inverse[1]) +
             half_solid_angle(w[0], w[2], w[3], volume * inverse[3]);
    }
  };

  /// Solid angle of the part whose first side is `width` long.
  TESSERA_INLINE Float solid_angle_up_to(Float width) const {
    return Corners(x0_, x0_ + width, y0_, y1_, z_).half_solid_angle_of(width, height_, z_).whole();
  }

  Float width_, height_, x0_, y0_, y1_, z_, solid_angle_, inverse_[4];
  Mask precise_;
};

}  // namespace tessera::render::TESSERA_ISA
