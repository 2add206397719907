#include "render/bsdf/conductor.h"

#include "render/bsdf/fresnel.h"
#include "render/bsdf/microfacet.h"

namespace tessera::render::TESSERA_ISA {

namespace {

constexpr int kAlpha = 0, kTint = 0;  // slots

TESSERA_INLINE Spectrum reflectance(const BsdfParams& params, Float cos_m) {
  const Spectrum fresnel = fresnel_conductor(cos_m, params.spectra[0], params.spectra[1]);
  if ((params.some_flags & kTinted) == 0) return fresnel;
  return select(params.with(kTinted), fresnel * params.extended_spectra[kTint], fresnel);
}

}  // namespace

BsdfEval ConductorBsdf::eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const {
  const Mask lit = and_not(active & same_hemisphere(wo, wi), is_smooth(params, kAlpha));
  if (none(lit)) return {Spectrum(0.0f), 0.0f};
  const Mask below = wo.z < 0.0f;
  const MicrofacetReflection reflection = with_microfacets(params, kAlpha, [&](const auto& facets) {
    return eval_reflection(facets, mirror_if(below, wo), mirror_if(below, wi));
  });
  return {reflectance(params, reflection.cos_m) * select_or_zero(lit, reflection.f_cos),
          select_or_zero(lit, reflection.pdf)};
}

BsdfSample ConductorBsdf::sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Mask active) const {
  const Mask below = wo.z < 0.0f;
  wo = mirror_if(below, wo);
  const Mask smooth = is_smooth(params, kAlpha);

  // The mirror, then microfacets where there are any.
  Vec3 wi{-wo.x, -wo.y, wo.z};
  Float cos_m = wo.z, geometry = 1.0f, pdf = 1.0f;
  if (any(and_not(active, smooth))) {
    with_microfacets(params, kAlpha, [&](const auto& facets) {
      const Vec3 wm = facets.sample_visible(wo, u);
      const Float cos_rough = dot(wo, wm);
      wi = select(smooth, wi, reflect(wo, wm, cos_rough));
      cos_m = select(smooth, cos_m, cos_rough);
      geometry = select(smooth, geometry, visible_weight(facets, wo, wi));
      pdf = select(smooth, pdf, reflection_pdf(facets, wo, wm));
    });
  }
  return {.wi = mirror_if(below, wi),
          .weight = reflectance(params, cos_m) * geometry,
          .pdf = pdf,
          .eta = 1.0f,
          .valid = active & (wo.z > 0.0f) & (wi.z > 0.0f),
          .specular = smooth,
          .transmission = Mask::none()};
}

}  // namespace tessera::render::TESSERA_ISA
