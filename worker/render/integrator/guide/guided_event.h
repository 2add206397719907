// Scattering of paths that follow a guide as often as it pays: one of two densities is sampled, and light is
// weighted by both together [Müller, Gross & Novák 2017, section 4.2].
#pragma once

#include "render/integrator/guide/guide_field.h"
#include "render/integrator/vertex/vertex.h"

namespace tessera::render::TESSERA_ISA {

/// Lanes of `events` that a guide is for: surfaces that scatter light evenly. Guided glossy ones lose
/// (docs/decisions/0045-path-guiding.md).
TESSERA_INLINE Mask guidable(const Vertex& v, Mask events) {
  return and_not(joinable(v, events) & reflects_only(v.at) & ((v.at.flags & kLambertian) != 0), v.in_medium);
}

/// The density of directions whose BSDF has `pdf`, the guide's included.
TESSERA_INLINE Float mixed_pdf(const GuideField& field, const Guided& guided, Vec3 wi, Float pdf,
                               Mask lanes) {
  const Mask both = lanes & guided.followed;
  if (none(both)) return pdf;
  return select(both, fma(kGuideFraction, field.pdf(guided, wi, both) - pdf, pdf), pdf);
}

/// A direction in which a path goes on, and what led to it.
struct GuidedSample {
  BsdfSample bsdf;  // pdf and weight are of both densities
  Float bsdf_pdf;   // of the BSDF alone
};

/// `u_lobe` and `u` are uniform in [0, 1).
GuidedSample sample_guided(const SceneTables& scene, const GuideField& field, const Guided& guided,
                           const Vertex& v, Float u_lobe, Vec2 u, Mask events);

}  // namespace tessera::render::TESSERA_ISA
