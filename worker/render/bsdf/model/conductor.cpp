// A conductor: mirror, or microfacets. pbrt-v4's "conductor", Mitsuba 3's "conductor" and "roughconductor".
//
// spectra[0]     eta: real part of the complex index of refraction, relative to the outside
// spectra[1]     k: its imaginary part
// scalars[0, 1]  alpha along x and y; a mirror where both are below kSmoothAlpha
// extended_spectra[0]  with kTinted: factor of the light
//
// With kBalanced what scatters more than once between the microfacets is not lost [balance.h].
#include "render/bsdf/bsdf.h"

#include "render/bsdf/balance.h"
#include "render/bsdf/fresnel.h"
#include "render/bsdf/microfacet.h"

namespace tessera::render::TESSERA_ISA {

namespace {

class ConductorBsdf final : public Bsdf {
 public:
  ConductorBsdf() : Bsdf(kReflectsOnly) {}
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport transport, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport transport,
                    Mask active) const override;
  Float least_alpha(const BsdfParams& params) const override;
  Spectrum albedo(const BsdfParams& params) const override;
  void prepare(const TexturePoint& at, Mask lanes, BsdfParams& params) const override;
};

TESSERA_INLINE Spectrum reflectance(const BsdfParams& params, Float cos_m) {
  const Spectrum fresnel =
      fresnel_conductor(cos_m, params.spectra[slot::kConductorEta], params.spectra[slot::kConductorK]);
  if ((params.some_variants & kTinted) == 0) return fresnel;
  return select(params.of_variant(kTinted), fresnel * params.extended_spectra[slot::kConductorTint], fresnel);
}

/// Mean reflectance for diffuse light: the Gauss-Jacobi rule with two points for the weight 2 cos(theta), to
/// 6e-3 for metals.
TESSERA_INLINE Spectrum mean_reflectance(const BsdfParams& params) {
  constexpr float kCosines[] = {0.35505103f, 0.84494897f}, kWeights[] = {0.36391725f, 0.63608275f};
  return reflectance(params, Float(kCosines[0])) * Float(kWeights[0]) +
         reflectance(params, Float(kCosines[1])) * Float(kWeights[1]);
}

/// By how much scattering between the facets brightens single scattering, for directions above the surface.
/// Inlined, it would cost the materials that have none.
[[gnu::noinline]] Spectrum gain(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask rough) {
  const Balance balance(params, rough);
  const Float added = balance.factor(wo, Mask::none()) * balance.factor(wi, Mask::none()) - 1.0f;
  const Float kept = balance.kept();
  const Spectrum mean = mean_reflectance(params);
  Spectrum result;
  for (int c = 0; c < kSpectrumLanes; ++c) {
    const Float r = mean.c[c];
    result.c[c] = fma(added, r * kept / max(1.0f - r * (1.0f - kept), 1e-6f), Float(1.0f));
  }
  return select(rough & params.of_variant(kBalanced), result, Spectrum(1.0f));
}

}  // namespace

BsdfEval ConductorBsdf::eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport, Mask active) const {
  const Mask lit = and_not(active & same_hemisphere(wo, wi), is_smooth(params, slot::kAlphaX));
  if (none(lit)) return {Spectrum(0.0f), 0.0f};
  const Mask below = wo.z < 0.0f;
  const MicrofacetReflection reflection = with_microfacets(params, slot::kAlphaX, [&](const auto& facets) {
    return eval_reflection(facets, mirror_if(below, wo), mirror_if(below, wi));
  });
  Spectrum f_cos = reflectance(params, reflection.cos_m) * select_or_zero(lit, reflection.f_cos);
  if (params.some_variants & kBalanced)
    f_cos *= gain(params, mirror_if(below, wo), mirror_if(below, wi), lit);
  return {f_cos, select_or_zero(lit, reflection.pdf)};
}

BsdfSample ConductorBsdf::sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport,
                                 Mask active) const {
  const Mask below = wo.z < 0.0f;
  wo = mirror_if(below, wo);
  const Mask smooth = is_smooth(params, slot::kAlphaX);

  // The mirror, then microfacets where there are any.
  Vec3 wi{-wo.x, -wo.y, wo.z};
  Float cos_m = wo.z, geometry = 1.0f, pdf = 1.0f;
  if (any(and_not(active, smooth))) {
    with_microfacets(params, slot::kAlphaX, [&](const auto& facets) {
      const Vec3 wm = facets.sample_visible(wo, u);
      const Float cos_rough = dot(wo, wm);
      wi = select(smooth, wi, reflect(wo, wm, cos_rough));
      cos_m = select(smooth, cos_m, cos_rough);
      geometry = select(smooth, geometry, visible_weight(facets, wo, wi));
      pdf = select(smooth, pdf, reflection_pdf(facets, wo, wm));
    });
  }
  const Mask valid = active & (wo.z > 0.0f) & (wi.z > 0.0f);
  Spectrum weight = reflectance(params, cos_m) * geometry;
  if (params.some_variants & kBalanced) weight *= gain(params, wo, wi, and_not(valid, smooth));
  return {.wi = mirror_if(below, wi),
          .weight = weight,
          .pdf = pdf,
          .eta = 1.0f,
          .valid = valid,
          .specular = smooth,
          .transmission = Mask::none()};
}

Float ConductorBsdf::least_alpha(const BsdfParams& params) const {
  return min(params.scalars[slot::kAlphaX], params.scalars[slot::kAlphaY]);
}

Spectrum ConductorBsdf::albedo(const BsdfParams& params) const {
  return normal_reflectance(params.spectra[slot::kConductorEta], params.spectra[slot::kConductorK]);
}

void ConductorBsdf::prepare(const TexturePoint&, Mask lanes, BsdfParams& params) const {
  conductor_of_reflectance(lanes, params.spectra[slot::kConductorEta], params.spectra[slot::kConductorK]);
}

const ModelOf<ConductorBsdf> conductor(BsdfKind::kConductor);

}  // namespace tessera::render::TESSERA_ISA
