// A dielectric coat, smooth or rough, over a Lambertian base, as Mitsuba 3's "plastic" and "roughplastic"
// model it [d'Eon & Irving 2011]:
//
//   f(wo, wi) = tint f_coat(wo, wi) + T(wo) T(wi) / (pi eta^2) rho / (1 - R)
//
// or, with kNonlinear, rho / (1 - rho R). T(w) is the part of light along w that the coat lets through and R
// the part of diffuse light from the base that it sends back: Fresnel's for smooth coats, tables for rough
// ones [plastic_table.h]. pbrt-v4's coat, whose energies are exact, is coated_diffuse.h. Seen from below it
// is the same again.
//
// spectra[0]     rho: reflectance of the base
// spectra[1]     tint: factor of the light that the coat reflects
// scalars[0, 1]  alpha of the coat; smooth below kSmoothAlpha
// scalars[2]     eta: index of the coat over the index outside
// coat_table     from append_plastic_table()
#pragma once

#include "render/bsdf/bsdf.h"

namespace tessera::render::TESSERA_ISA {

class PlasticBsdf final : public Bsdf {
 public:
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Mask active) const override;
};

}  // namespace tessera::render::TESSERA_ISA
