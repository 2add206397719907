// Delta lobes by what they do instead of by a random number: interfaces of BSDFs only sample them.
#pragma once

#include "render/integrator/interaction.h"

namespace tessera::render::TESSERA_ISA {

/// Delta lobes of sixteen vertices.
struct DeltaLobe {
  Vec3 wi{Float(0.0f), Float(0.0f), Float(0.0f)};
  Spectrum weight = Spectrum(0.0f);  // BsdfSample::weight
  Float probability = Float(0.0f);
  Float eta = Float(1.0f);  // BsdfSample::eta
  Mask found = Mask::none(), transmission = Mask::none();
};

/// The delta lobe of light that comes from (or leaves along) `wo` for which `fits(sample)` holds. Lobes are
/// intervals of the number that picks them, which begin at its ends in all models; a narrow one in the middle
/// may be missed: that depends on the vertex alone, so that chains only never get there.
template <class Fits>
TESSERA_INLINE DeltaLobe find_delta_lobe(const Interaction& at, Vec3 wo, Transport transport, Mask active,
                                         Fits&& fits) {
  DeltaLobe lobe;
  for (const float u_lobe : {0.0f, 0.99999f, 0.5f, 0.25f, 0.75f, 0.01f, 0.98f}) {
    const Mask left = and_not(active, lobe.found);
    if (none(left)) break;
    const BsdfSample sample = sample_bsdf(at, wo, Float(u_lobe), {Float(0.5f), Float(0.5f)}, left, transport);
    const Mask found = left & sample.valid & sample.specular & fits(sample);
    lobe.wi = select(found, sample.wi, lobe.wi);
    lobe.weight = select(found, sample.weight, lobe.weight);
    lobe.probability = select(found, sample.pdf, lobe.probability);
    lobe.eta = select(found, sample.eta, lobe.eta);
    lobe.transmission |= found & sample.transmission;
    lobe.found |= found;
  }
  return lobe;
}

/// Lobes that lead along `wi`, but for rounding: lobes of one vertex are far apart.
TESSERA_INLINE auto leads_along(Vec3 wi) {
  return [wi](const BsdfSample& sample) { return dot(sample.wi, wi) > 0.999f; };
}
/// Lobes that let light through where `transmits` says so, and others mirror it.
TESSERA_INLINE auto goes_through(Mask transmits) {
  return [transmits](const BsdfSample& sample) { return ~(sample.transmission ^ transmits); };
}

}  // namespace tessera::render::TESSERA_ISA
