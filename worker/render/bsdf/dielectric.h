// The boundary of a dielectric: mirror and refraction, or microfacets that do both [Walter et al. 2007].
// pbrt-v4's "dielectric", Mitsuba 3's "dielectric" and "roughdielectric".
//
// spectra[0, 1]  with kTinted: factors of reflected and of transmitted light
// scalars[0, 1]  alpha along x and y; smooth where both are below kSmoothAlpha
// scalars[2]     eta: index below the surface (z < 0) over the index above
#pragma once

#include "render/bsdf/bsdf.h"

namespace tessera::render::TESSERA_ISA {

class DielectricBsdf final : public Bsdf {
 public:
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Mask active) const override;
};

}  // namespace tessera::render::TESSERA_ISA
