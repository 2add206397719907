// A dielectric coat, smooth or rough, over a Lambertian base: pbrt-v4's "coateddiffuse". Seen from below it
// is the same again.
//
// The closed form of the random walk between the two: a Lambertian base forgets where light came from, so
// only energies matter, and the orders of interreflection are a geometric series:
//
//   f(wo, wi) = f_coat(wo, wi) + T(wo) T(wi) / (pi eta^2) rho / (1 - rho R_int)
//
// T(w) is the part of light along w that the coat lets through to the base, R_int the part of diffuse light
// from the base that it sends back; by reciprocity T(wo) / eta^2 of the base's diffuse radiance leaves along
// wo. Smooth coats have T = 1 - Fresnel; for rough ones T and R_int are tabulated for isotropic roughness
// [coat_table.h].
//
// For the energies of an anisotropic coat, and only for them, an isotropic roughness stands in: the root mean
// square of both, turning into the roughness along the light's plane towards grazing directions. That keeps
// within a few percent of the walk, and is exact where both are equal. There is no medium in between: the
// albedo of one is not looked at. The coat's thickness absorbs, as in pbrt-v4; for rough coats as if light
// crossed them as it does smooth ones.
//
// spectra[0]     rho: reflectance of the base, clamped to [0, 1]
// scalars[0, 1]  GGX alpha of the coat along x and y; smooth where both are below kSmoothAlpha
// scalars[2]     eta: index of the coat over the index outside
// coat_table     from append_coat_table(eta, thickness, ...)
#pragma once

#include "render/bsdf/bsdf.h"

namespace tessera::render::TESSERA_ISA {

class CoatedDiffuseBsdf final : public Bsdf {
 public:
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Mask active) const override;
};

}  // namespace tessera::render::TESSERA_ISA
