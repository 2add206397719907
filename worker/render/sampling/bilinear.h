// A distribution over the unit square whose density is bilinear: a first guess of an integrand that is known
// at the four corners [Hart et al. 2020].
#pragma once

#include "render/core/constants.h"
#include "render/core/vec.h"

namespace tessera::render::TESSERA_ISA {

/// Densities at the corners, positive and not normalised.
struct Bilinear {
  Float w00, w10, w01, w11;  // the first digit is x

  /// Over the unit square.
  TESSERA_INLINE Float density(Vec2 p) const {
    const Float value = lerp(p.y, lerp(p.x, w00, w10), lerp(p.x, w01, w11));
    return 4.0f * value / (w00 + w10 + w01 + w11);
  }

  /// `u` is uniform in [0, 1)^2. The strata of one axis stay whole.
  TESSERA_INLINE Vec2 sample(Vec2 u) const {
    const Float y = invert_linear(u.y, w00 + w10, w01 + w11);
    return {invert_linear(u.x, lerp(y, w00, w01), lerp(y, w10, w11)), y};
  }

 private:
  /// Where the CDF of a density that goes linearly from a to b over the unit interval is u.
  static TESSERA_INLINE Float invert_linear(Float u, Float a, Float b) {
    const Float x = u * (a + b) / (a + sqrt(lerp(u, sqr(a), sqr(b))));
    return min(x, kOneMinusEpsilon);
  }
};

}  // namespace tessera::render::TESSERA_ISA
