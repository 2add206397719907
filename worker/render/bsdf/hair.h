// A fibre of hair: a rough cylinder of dielectric with tilted scales, seen from afar [Chiang et al. 2016;
// d'Eon et al. 2011; Marschner et al. 2003], with the parameters of pbrt-v4's "hair". Directions are those of
// the shading frame with x along the fibre; light that goes through it comes out on the other side of the
// same surface.
//
// spectra[0]     sigma_a: absorption per radius
// scalars[0, 1]  beta_m, beta_n: longitudinal and azimuthal roughness in [0, 1]
// scalars[2]     eta: index of the fibre over the index outside
// extended[0]    alpha: tilt of the scales, radians
// extended[1]    h: where across the fibre it is hit, -1 to 1 (from prepare_hair())
#pragma once

#include "render/bsdf/bsdf.h"

namespace tessera::render::TESSERA_ISA {

class HairBsdf final : public Bsdf {
 public:
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Mask active) const override;
};

/// Completes the slots of `lanes`: h from the surface's parameter `v` across the fibre, and, with
/// kHairReflectance, the absorption that gives much hair the colour in spectra[0] [Chiang et al. 2016].
void prepare_hair(Float v, Mask lanes, BsdfParams& params);

}  // namespace tessera::render::TESSERA_ISA
