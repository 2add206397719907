// Lambertian reflection on the side of wo, Lambertian transmission to the other. pbrt-v4's
// "diffusetransmission".
//
// spectra[0]  reflectance, clamped to [0, 1]
// spectra[1]  transmittance, clamped to [0, 1]
#pragma once

#include "render/bsdf/bsdf.h"

namespace tessera::render::TESSERA_ISA {

class DiffuseTransmissionBsdf final : public Bsdf {
 public:
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Mask active) const override;
};

}  // namespace tessera::render::TESSERA_ISA
