// The boundary of a dielectric: mirror and refraction, or microfacets that do both [Walter et al. 2007].
// pbrt-v4's "dielectric", Mitsuba 3's "dielectric" and "roughdielectric".
//
// spectra[0, 1]  with kTinted: factors of reflected and of transmitted light
// scalars[0, 1]  alpha along x and y; smooth where both are below kSmoothAlpha
// scalars[2]     eta: index below the surface (z < 0) over the index above; with kDisperses, of rough ones,
//                that of the first wavelength
#include "render/bsdf/bsdf.h"

#include "render/bsdf/balance.h"
#include "render/bsdf/dispersed.h"
#include "render/bsdf/fresnel.h"
#include "render/bsdf/microfacet.h"
#include "render/bsdf/tint.h"

namespace tessera::render::TESSERA_ISA {

namespace {

class DielectricBsdf final : public Bsdf {
 public:
  DielectricBsdf() : Bsdf(kRefracts) {}
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport transport, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport transport,
                    Mask active) const override;
  Passing passing(const BsdfParams& params, Float cosine) const override;
};

/// Index of the side that wo is not on over that of wo's side.
TESSERA_INLINE Float relative_eta(const BsdfParams& params, Mask below) {
  const Float eta = params.scalars[slot::kEta];
  return select(below, 1.0f / eta, eta);
}

}  // namespace

BsdfEval DielectricBsdf::eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport transport,
                              Mask active) const {
  const Mask rough = and_not(active & (wo.z != 0.0f) & (wi.z != 0.0f),
                             is_smooth_dielectric(params, slot::kAlphaX, slot::kEta));
  if (none(rough)) return {Spectrum(0.0f), 0.0f};
  const Mask below = wo.z < 0.0f;
  const Float eta = relative_eta(params, below);
  wo = mirror_if(below, wo);
  wi = mirror_if(below, wi);
  const Mask reflected = wi.z > 0.0f;

  // The normal that scatters wo to wi, turned upwards [Walter et al. 2007, eqs. 13 and 16]; not unit.
  Vec3 h = fma(wi, select(reflected, 1.0f, eta), wo);
  h = select(h.z < 0.0f, -h, h);
  const Float oh = dot(wo, h), ih = dot(wi, h);
  const Mask facing = (oh > 0.0f) & (ih * wi.z > 0.0f);
  const Float h2 = select(facing, length_squared(h), 1.0f);
  const Float r = fresnel_dielectric(oh / sqrt(h2), eta).reflectance;

  // Both densities are that of h times a Jacobian dh/dwi; the Fresnel factor chooses the lobe. Refracted
  // radiance is scaled by 1 / eta^2.
  const Mask lit = rough & facing;
  BsdfEval result = with_microfacets(params, slot::kAlphaX, [&](const auto& facets) -> BsdfEval {
    const Float zi = abs_cos_theta(wi);
    const Float so = facets.masking_length(wo), si = facets.masking_length({wi.x, wi.y, zi});
    const Float refraction = (1.0f - r) * 2.0f * abs(oh * ih) / sqr(h2);
    const Float scatter = facets.density(h) * select(reflected, 0.5f * r, refraction);
    const Float pdf = scatter * select(reflected, 1.0f, sqr(eta)) / (wo.z + so);
    const Spectrum f_cos(select_or_zero(lit, scatter * zi / facets.masking_pair(so, wo.z, si, zi)));
    return {tinted(params, reflected, f_cos), select_or_zero(lit, pdf)};
  });
  if (params.some_variants & kBalanced) result.f_cos *= balance_factor(params, wo, wi, below, lit);
  result.f_cos = transported(transport, ~reflected, eta, result.f_cos);
  return result;
}

namespace {

/// sample() for microfacets of one type; all rough lanes have it. `wo` is above the surface.
template <class Facets>
TESSERA_INLINE BsdfSample sample_above(const BsdfParams& params, const Facets& facets, Vec3 wo, Mask below,
                                       Mask delta, bool any_rough, Float u_lobe, Vec2 u) {
  const Float eta = relative_eta(params, below);
  // A normal, then reflection or refraction by its Fresnel reflectance.
  Vec3 wm{0.0f, 0.0f, 1.0f};
  if (any_rough) wm = select(delta, wm, facets.sample_visible(wo, u));
  const Float cos_m = dot(wo, wm);
  const DielectricFresnel fresnel = fresnel_dielectric(cos_m, eta);
  Float mirror = fresnel.reflectance;
  const bool some_split = some_disperse(params);
  const Mask split = some_split ? delta & params.with(kDisperses) : Mask::none();
  const Spectrum each = some_split ? reflectances(params, cos_m, below) : Spectrum(mirror);
  if (some_split) mirror = select(split, each.mean(), mirror);
  const Mask reflected = u_lobe < mirror;
  const Vec3 wi = select(reflected, reflect(wo, wm, cos_m), refract(wo, wm, cos_m, eta, fresnel));
  const Float zi = abs_cos_theta(wi);

  Float weight = select(reflected, 1.0f, 1.0f / sqr(eta));
  Float pdf = select(reflected, mirror, 1.0f - mirror);
  if (any_rough) {
    // Density of the visible normal, apart from its cos_m, times the Jacobian of reflection or refraction
    // with it.
    const Float visible = 2.0f * facets.density(wm) / (wo.z + facets.masking_length(wo));
    const Float g = fresnel.eta_cos_t;
    const Float jacobian = select(reflected, 0.25f, eta * g * cos_m / sqr(cos_m - g));
    weight = weight * select(delta, 1.0f, visible_weight(facets, wo, {wi.x, wi.y, zi}));
    pdf = pdf * select(delta, 1.0f, visible * jacobian);
  }
  BsdfSample result{
      .wi = wi,
      .weight = Spectrum(weight),
      .pdf = pdf,
      .eta = select(reflected, 1.0f, eta),
      .valid = (wo.z > 0.0f) & (cos_m > 0.0f) & (zi > 0.0f) & (reflected ^ (wi.z < 0.0f)) & (pdf > 0.0f),
      .specular = delta,
      .transmission = ~reflected};
  if (some_split) {
    const Spectrum share = select(reflected, each, Spectrum(1.0f - fresnel.reflectance));
    result.weight = select(split, result.weight * share * (1.0f / max(pdf, 1e-30f)), result.weight);
  }
  return result;
}

}  // namespace

BsdfSample DielectricBsdf::sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u,
                                  Transport transport, Mask active) const {
  const Mask below = wo.z < 0.0f;
  const Mask delta = is_smooth_dielectric(params, slot::kAlphaX, slot::kEta);
  const bool any_rough = any(and_not(active, delta));
  wo = mirror_if(below, wo);
  BsdfSample result = with_microfacets(params, slot::kAlphaX, [&](const auto& facets) {
    return sample_above(params, facets, wo, below, delta, any_rough, u_lobe, u);
  });
  result.valid &= active;
  result.weight = tinted(params, ~result.transmission, result.weight);
  if (params.some_variants & kBalanced) {
    result.weight *= balance_factor(params, wo, result.wi, below, and_not(result.valid, delta));
  }
  result.weight = transported(transport, result.transmission, relative_eta(params, below), result.weight);
  result.wi = mirror_if(below, result.wi);
  return result;
}

/// The square root of what a pane lets through in all orders of reflection between its two sides.
Passing DielectricBsdf::passing(const BsdfParams& params, Float cosine) const {
  const auto through = [](Float once) { return sqrt((1.0f - once) / (1.0f + once)); };
  const Spectrum tint = tinted(params, Mask::none(), Spectrum(1.0f));
  if (some_disperse(params)) {
    Spectrum part = reflectances(params, cosine, Mask::none());
    for (Float& lane : part.c) lane = through(lane);
    return passing_of(part, tint);
  }
  return {through(fresnel_dielectric(cosine, params.scalars[slot::kEta]).reflectance), tint};
}

const ModelOf<DielectricBsdf> dielectric(BsdfKind::kDielectric);

}  // namespace tessera::render::TESSERA_ISA
