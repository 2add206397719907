// A dielectric coat over a Lambertian base: what the models of pbrt-v4 (coated_diffuse.h) and Mitsuba 3
// (plastic.h) have in common. They differ in the energies, which a class of theirs gives:
//
//   class Coat {                                            // for directions above the surface
//     Coat(const BsdfParams& params, Mask active);
//     Float eta;                                            // index of the coat over the index outside
//     Mask smooth;
//     bool any_rough() const;
//     Float transmittance(Vec3 w) const;                    // T(w)
//     Float reflectance(Vec3 w) const;                      // the coat's: below 1 - T where it absorbs
//     Float internal;                                       // R
//     Float one_minus_colour(Float rho) const;              // 1 - rho R, or what stands for it
//     Spectrum tinted(const BsdfParams&, Spectrum) const;   // light that the coat reflected
//   };
#pragma once

#include "render/bsdf/bsdf.h"
#include "render/bsdf/fresnel.h"
#include "render/bsdf/microfacet.h"

namespace tessera::render::TESSERA_ISA {

/// Terms that depend on wo only: radiance that leaves along wo per irradiance that enters, and how to choose
/// a lobe.
struct CoatLobes {
  Float fresnel_o;  // Fresnel factor of a smooth coat; has no meaning for others
  Spectrum base;    // T(wo) rho / (eta^2 (1 - rho R))
  Float coat;       // probability of sampling the coat's lobe

  template <class Coat>
  TESSERA_INLINE CoatLobes(const BsdfParams& params, const Coat& coat_energy, Vec3 wo) {
    const Float transmitted = coat_energy.transmittance(wo);
    fresnel_o = coat_energy.reflectance(wo);
    const Spectrum rho = clamp(params.spectra[slot::kReflectance], 0.0f, 1.0f);
    const Float factor = transmitted / sqr(coat_energy.eta);
    for (int i = 0; i < kSpectrumLanes; ++i) {
      base.c[i] = factor * rho.c[i] / max(coat_energy.one_minus_colour(rho.c[i]), 1e-6f);
    }
    // By energy, as far as it is known without integration: diffuse light leaves a smooth coat as 1 - R does.
    const Float base_energy = base.max_component() * sqr(coat_energy.eta) * (1.0f - coat_energy.internal);
    const Float coat_power = coat_energy.tinted(params, Spectrum(fresnel_o)).max_component();
    const Float sum = coat_power + base_energy;
    coat = coat_power / select(sum > 0.0f, sum, 1.0f);
  }
};

/// f cos and pdf of both lobes, delta lobes apart, where `lit`.
template <class Coat>
TESSERA_INLINE BsdfEval eval_coat_lobes(const BsdfParams& params, const Coat& coat, const CoatLobes& lobes,
                                        Vec3 wo, Vec3 wi, Mask lit) {
  const Float cosine = select_or_zero(lit, wi.z * kInvPi);
  BsdfEval result{lobes.base * (coat.transmittance(wi) * cosine), (1.0f - lobes.coat) * cosine};
  if (coat.any_rough()) {
    const Mask rough = and_not(lit, coat.smooth);
    const MicrofacetReflection reflection = with_microfacets(
        params, slot::kAlphaX, [&](const auto& facets) { return eval_reflection(facets, wo, wi); });
    const Float fresnel = fresnel_dielectric(reflection.cos_m, coat.eta).reflectance;
    result.f_cos += coat.tinted(params, Spectrum(select_or_zero(rough, fresnel * reflection.f_cos)));
    result.pdf += select_or_zero(rough, lobes.coat * reflection.pdf);
  }
  return result;
}

/// Bsdf::eval of the model with this coat.
template <class Coat>
TESSERA_INLINE BsdfEval eval_coat_over_diffuse(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) {
  const Mask lit = active & same_hemisphere(wo, wi);
  if (none(lit)) return {Spectrum(0.0f), 0.0f};
  const Mask below = wo.z < 0.0f;
  wo = mirror_if(below, wo);
  wi = mirror_if(below, wi);
  const Coat coat(params, lit);
  BsdfEval result = eval_coat_lobes(params, coat, CoatLobes(params, coat, wo), wo, wi, lit);
  result.f_cos = select_or_zero(lit, result.f_cos);
  return result;
}

/// Bsdf::diffuse_share of the model with this coat: what the base gives.
template <class Coat>
TESSERA_INLINE Float share_below_coat(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) {
  const Mask lit = active & same_hemisphere(wo, wi);
  const Mask below = wo.z < 0.0f;
  wo = mirror_if(below, wo);
  wi = mirror_if(below, wi);
  const Coat coat(params, lit);
  if (!coat.any_rough()) return Float(1.0f);
  const CoatLobes lobes(params, coat, wo);
  const Spectrum base = lobes.base * (coat.transmittance(wi) * select_or_zero(lit, wi.z * kInvPi));
  return share_of(base, eval_coat_lobes(params, coat, lobes, wo, wi, lit).f_cos);
}

/// Bsdf::sample of the model with this coat.
template <class Coat>
TESSERA_INLINE BsdfSample sample_coat_over_diffuse(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u,
                                                   Mask active) {
  const Mask below = wo.z < 0.0f;
  wo = mirror_if(below, wo);
  active &= wo.z > 0.0f;
  const Coat coat(params, active);
  const CoatLobes lobes(params, coat, wo);

  // A direction from one of the lobes.
  const Mask off_coat = u_lobe < lobes.coat;
  Vec3 wi{-wo.x, -wo.y, wo.z};
  if (any(active & off_coat) && coat.any_rough()) {
    const Vec3 wm = with_microfacets(params, slot::kAlphaX,
                                     [&](const auto& facets) { return facets.sample_visible(wo, u); });
    wi = select(coat.smooth, wi, reflect(wo, wm, dot(wo, wm)));
  }
  if (any(and_not(active, off_coat))) wi = select(off_coat, wi, square_to_cosine_hemisphere(u));

  // Its weight over both lobes, unless it came from a mirror.
  const Mask mirror = off_coat & coat.smooth;
  const Mask lit = active & (wi.z > 0.0f);
  BsdfEval eval = eval_coat_lobes(params, coat, lobes, wo, wi, lit);
  eval.f_cos = select(mirror, coat.tinted(params, Spectrum(lobes.fresnel_o)), eval.f_cos);
  eval.pdf = select(mirror, lobes.coat, eval.pdf);
  const Mask valid = lit & (eval.pdf > 0.0f);
  return {.wi = mirror_if(below, wi),
          .weight = eval.f_cos * (1.0f / select(valid, eval.pdf, 1.0f)),
          .pdf = eval.pdf,
          .eta = 1.0f,
          .valid = valid,
          .specular = mirror,
          .transmission = Mask::none()};
}

}  // namespace tessera::render::TESSERA_ISA
