// Lambertian reflection, on whichever side wo is [Lambert 1760]. pbrt-v4's and Mitsuba 3's "diffuse".
//
// spectra[0]  reflectance, clamped to [0, 1]
#pragma once

#include "render/bsdf/bsdf.h"

namespace tessera::render::TESSERA_ISA {

class DiffuseBsdf final : public Bsdf {
 public:
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Mask active) const override;
};

}  // namespace tessera::render::TESSERA_ISA
