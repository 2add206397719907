#include "render/transport/guide/guide_steering.h"

namespace tessera::render::TESSERA_ISA {

GuideCells guide_cells_at(const Encounter& e, const SampleBatch& batch) {
  const Vertex& v = e.vertex;
  const UInt key = hash(batch.key(e.path.slot, e.met), UInt(static_cast<std::uint32_t>(e.depth)));
  return guide_cells_at(v.surface.p, face_forward(v.at.frame.z, v.wo),
                        {to_unit_float(key), to_unit_float(hash(key))});
}

void GuideSteering::met(Encounter& e) {
  cells_ = guide_cells_at(e, batch_);
  guided_ = field_.at(cells_, guidable(e.vertex, e.met));
  e.steered = select(guided_.followed, guided_.density, Int(-1));
}

Float GuideSteering::pdf(Int steered, Vec3 wi, Float bsdf_pdf, Mask lanes) const {
  const Guided guided = {.known = lanes, .followed = lanes & (steered >= 0), .density = steered};
  if (none(guided.followed)) return bsdf_pdf;
  return select(guided.followed,
                fma(kGuideFraction, field_.pdf(guided, wi, guided.followed) - bsdf_pdf, bsdf_pdf), bsdf_pdf);
}

BsdfSample GuideSteering::sample(const Encounter& e, Vec2 u, Mask lanes) {
  const Vertex& v = e.vertex;
  const Float u_lobe = e.choice.y;
  const Mask both = lanes & guided_.followed;
  const Mask follow = both & (u_lobe < kGuideFraction);
  // The rest of the number chooses the lobe.
  const Float rest = min((u_lobe - kGuideFraction) * (1 / (1 - kGuideFraction)), kOneMinusEpsilon);
  BsdfSample s =
      sample_scattering(scene_, v, select(both, max(rest, 0.0f), u_lobe), u, and_not(lanes, follow));
  bsdf_pdf_ = s.pdf;
  // The lobes of surfaces that are guided are none of them delta functions.
  if (const Mask scatter = and_not(both & s.valid, follow); any(scatter)) {
    const Float mixed = pdf(e.steered, s.wi, s.pdf, scatter);
    s.weight = select(scatter, s.weight * (s.pdf / mixed), s.weight);
    s.pdf = select(scatter, mixed, s.pdf);
  }
  if (none(follow)) return s;

  const Vec3 wi = field_.sample(guided_, u, follow);
  const BsdfEval eval = eval_scattering(scene_, v, wi, follow);
  const Float mixed = pdf(e.steered, wi, eval.pdf, follow);
  s.wi = select(follow, wi, s.wi);
  s.weight = select(follow, eval.f_cos * (1.0f / select(follow, mixed, 1.0f)), s.weight);
  s.pdf = select(follow, mixed, s.pdf);
  s.eta = select(follow, 1.0f, s.eta);
  s.valid |= follow;
  s.specular = and_not(s.specular, follow);
  s.transmission = and_not(s.transmission, follow);
  bsdf_pdf_ = select(follow, eval.pdf, bsdf_pdf_);
  return s;
}

/// Roulette goes by what samples of the BSDF would have brought: those that follow the guide have little
/// throughput because there are many of them.
void GuideSteering::scattered(const Encounter&, Scattering& s) {
  const Mask guided = guided_.followed & (bsdf_pdf_ > 0.0f);
  s.next.roulette_scale *= select(guided, max(s.bsdf.pdf / bsdf_pdf_, 1.0f), 1.0f);
}

}  // namespace tessera::render::TESSERA_ISA
