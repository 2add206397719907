// Mitsuba 3's "principledthin", Disney's model for sheets without thickness [Burley 2015]: glass that
// reflects and lets through without bending, and a diffuse base that does both. Both sides are the same.
//
// spectra[0]   base colour
// scalars      roughness, anisotropic, eta: index of the sheet over the index around it
// extended     spec_trans, spec_tint, sheen, sheen_tint, flatness, diff_trans (0 to 2)
#pragma once

#include "render/bsdf/bsdf.h"

namespace tessera::render::TESSERA_ISA {

class PrincipledThinBsdf final : public Bsdf {
 public:
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Mask active) const override;
};

}  // namespace tessera::render::TESSERA_ISA
