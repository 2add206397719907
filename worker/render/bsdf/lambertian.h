// Lambertian reflection where all that is known of the directions are their cosines with the normal.
#pragma once

#include "render/bsdf/bsdf.h"
#include "render/core/constants.h"

namespace tessera::render::TESSERA_ISA {

/// Returns what Bsdf::eval() gives for a surface that reflects on whichever side wo is; `reflectance` is
/// clamped to [0, 1] [Lambert 1760].
TESSERA_INLINE BsdfEval eval_lambertian(Spectrum reflectance, Float cos_o, Float cos_i, Mask active) {
  const Float pdf = select_or_zero(active & (cos_o * cos_i > 0.0f), abs(cos_i) * kInvPi);
  return {clamp(reflectance, 0.0f, 1.0f) * pdf, pdf};
}

}  // namespace tessera::render::TESSERA_ISA
