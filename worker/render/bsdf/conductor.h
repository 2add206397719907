// A conductor: mirror, or microfacets. pbrt-v4's "conductor", Mitsuba 3's "conductor" and "roughconductor".
//
// spectra[0]     eta: real part of the complex index of refraction, relative to the outside
// spectra[1]     k: its imaginary part
// scalars[0, 1]  alpha along x and y; a mirror where both are below kSmoothAlpha
// extended_spectra[0]  with kTinted: factor of the light
//
// With kBalanced what scatters more than once between the microfacets is not lost [balance.h].
#pragma once

#include "render/bsdf/bsdf.h"

namespace tessera::render::TESSERA_ISA {

class ConductorBsdf final : public Bsdf {
 public:
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Mask active) const override;
};

}  // namespace tessera::render::TESSERA_ISA
