// A dielectric coat over a conductor: pbrt-v4's "coatedconductor". Seen from below it is the same again.
//
// There is no closed form for what goes back and forth between two rough boundaries: eval() and the weight of
// sample() are estimates from random walks, unbiased, as in [Guo et al. 2018; Pharr et al. 2023, sec. 14.3].
// The walks take their numbers from hashes of the directions, so that equal arguments give equal results.
// `pdf` is not the density that the walks have but a smooth function like it, the same in eval() and
// sample(): good for weighing against light sampling, which needs no more, but not for dividing by.
//
// spectra[0, 1]   eta and k of the conductor, relative to the outside
// scalars[0, 1]   GGX alpha of the coat along x and y
// scalars[2]      eta: index of the coat over the index outside
// extended[0, 1]  GGX alpha of the conductor along x and y
// extended[2]     optical thickness of the coat along the normal, all of it absorption
#pragma once

#include "render/bsdf/bsdf.h"

namespace tessera::render::TESSERA_ISA {

class CoatedConductorBsdf final : public Bsdf {
 public:
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Mask active) const override;
};

}  // namespace tessera::render::TESSERA_ISA
