#include "render/integrator/guide/guided_event.h"

namespace tessera::render::TESSERA_ISA {

GuidedSample sample_guided(const SceneTables& scene, const GuideField& field, const Guided& guided,
                           const Vertex& v, Float u_lobe, Vec2 u, Mask events) {
  const Mask both = events & guided.followed;
  const Mask follow = both & (u_lobe < kGuideFraction);
  // What is left of the number chooses the lobe.
  const Float rest = min((u_lobe - kGuideFraction) * (1 / (1 - kGuideFraction)), kOneMinusEpsilon);
  GuidedSample result;
  BsdfSample& s = result.bsdf;
  s = sample_scattering(scene, v, select(both, max(rest, 0.0f), u_lobe), u, and_not(events, follow));
  result.bsdf_pdf = s.pdf;
  // The lobes of surfaces that are guided are none of them delta functions.
  if (const Mask scatter = and_not(both & s.valid, follow); any(scatter)) {
    const Float mixed = mixed_pdf(field, guided, s.wi, s.pdf, scatter);
    s.weight = select(scatter, s.weight * (s.pdf / mixed), s.weight);
    s.pdf = select(scatter, mixed, s.pdf);
  }
  if (none(follow)) return result;

  const Vec3 wi = field.sample(guided, u, follow);
  const BsdfEval eval = eval_scattering(scene, v, wi, follow);
  const Float mixed = mixed_pdf(field, guided, wi, eval.pdf, follow);
  s.wi = select(follow, wi, s.wi);
  s.weight = select(follow, eval.f_cos * (1.0f / select(follow, mixed, 1.0f)), s.weight);
  s.pdf = select(follow, mixed, s.pdf);
  s.eta = select(follow, 1.0f, s.eta);
  s.valid |= follow;
  s.specular = and_not(s.specular, follow);
  s.transmission = and_not(s.transmission, follow);
  result.bsdf_pdf = select(follow, eval.pdf, result.bsdf_pdf);
  return result;
}

}  // namespace tessera::render::TESSERA_ISA
