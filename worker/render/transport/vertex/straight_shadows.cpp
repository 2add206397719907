#include "render/transport/vertex/straight_shadows.h"

namespace tessera::render::TESSERA_ISA {

void StraightShadows::scattered(const Encounter& e, Scattering& s) {
  const Vertex& v = e.vertex;
  const BsdfSample& bsdf = s.bsdf;
  const Mask bent = and_not(s.lanes & bsdf.specular, v.in_medium);
  if (none(bent)) return;
  const Mask glass = clear_glass_at(scene_, v.surface, e.path.direction, bent);
  const Mask inside = glass & ((v.at.traits & kRefracts) != 0) & (dot(v.wo, v.at.frame.z) < 0.0f);
  const Mask mirrored = and_not(inside, bsdf.transmission), leaving = inside & bsdf.transmission;
  const Mask kept = mirrored | (glass & bsdf.transmission);
  const auto keep = [&](const auto& before, auto& now) { now = select(kept, before, now); };
  keep(select(mirrored, -e.path.pdf, select(leaving, max(e.path.pdf, 0.0f), e.path.pdf)), s.next.pdf);
  keep(e.path.reference, s.next.reference);
  if (scene_.lights.uses_normals) keep(e.path.normal, s.next.normal);
}

}  // namespace tessera::render::TESSERA_ISA
