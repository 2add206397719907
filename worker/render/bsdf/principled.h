// Mitsuba 3's "principled", Disney's model [Burley 2012, 2015]: a metal, a glass (both GGX microfacets of one
// roughness) and a diffuse base with sheen in proportions, under a clear coat. From inside there is only the
// glass; where light cannot get through (no kHasInside) it is the same from below.
//
// spectra[0]   base colour
// scalars      roughness, anisotropic, eta: index below the surface over the index above
// extended     metallic, spec_trans, spec_tint, sheen, sheen_tint, flatness, clearcoat, clearcoat_gloss
#pragma once

#include "render/bsdf/bsdf.h"

namespace tessera::render::TESSERA_ISA {

class PrincipledBsdf final : public Bsdf {
 public:
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Mask active) const override;
};

}  // namespace tessera::render::TESSERA_ISA
