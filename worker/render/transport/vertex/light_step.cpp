#include "render/transport/vertex/light_step.h"

#include "render/transport/vertex/dispersion.h"
#include "render/transport/vertex/light_start.h"

namespace tessera::render::TESSERA_ISA {

LightStep step_from_light(const SceneTables& scene, const Vertex& v, const WidePath& path, Float u_lobe,
                          Vec2 u, Mask hit) {
  const BsdfSample bsdf = sample_scattering(scene, v, u_lobe, u, hit, Transport::kImportance);
  const Mask spread = and_not(hit & bsdf.valid, bsdf.specular);
  // The light that leaves is what paths from the eye would find: their value, over the density of this side.
  const BsdfEval back = eval_scattering(scene, v, bsdf.wi, v.wo, spread);
  const Spectrum exact = back.f_cos * (adjoint_ratio(v, bsdf.wi) / max(bsdf.pdf, 1e-37f));
  const Spectrum sampled =
      bsdf.weight * select(v.in_medium, 1.0f, normal_ratio(v.surface, v.at.frame, v.wo, bsdf.wi));
  LightStep step;
  WidePath& next = step.next;
  next = path;
  next.origin = next.reference = offset_origin(v.surface, bsdf.wi);
  next.direction = bsdf.wi;
  if (scene.volumetric)
    next.medium = medium_behind(scene.shapes, v.surface, bsdf.wi, v.medium, and_not(hit, v.in_medium));
  next.beta = path.beta * select(and_not(spread, estimates_density(v.at, spread)), exact, sampled);
  disperse_along(scene, v, bsdf, next);
  step.pdf = bsdf.pdf;
  step.back_pdf = back.pdf;
  step.specular = bsdf.specular;
  step.alive = and_not(hit & bsdf.valid & is_finite(next.beta), is_black(next.beta));
  return step;
}

}  // namespace tessera::render::TESSERA_ISA
