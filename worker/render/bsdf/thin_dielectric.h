// A sheet of dielectric without thickness: all orders of reflection between its two sides, no refraction.
// pbrt-v4's "thindielectric", Mitsuba 3's "thindielectric".
//
// spectra[0, 1]  with kTinted: factors of reflected and of transmitted light
// scalars[2]     eta: index of the sheet over the index around it
#pragma once

#include "render/bsdf/bsdf.h"

namespace tessera::render::TESSERA_ISA {

class ThinDielectricBsdf final : public Bsdf {
 public:
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Mask active) const override;
};

}  // namespace tessera::render::TESSERA_ISA
