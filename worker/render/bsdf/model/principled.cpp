// Mitsuba 3's "principled", Disney's model [Burley 2012, 2015]: a metal, a glass (both GGX microfacets of one
// roughness) and a diffuse base with sheen in proportions, under a clear coat. From inside there is only the
// glass; where light cannot get through (no kHasInside) it is the same from below.
//
// spectra[0]   base colour
// scalars      roughness, anisotropic, eta: index below the surface over the index above
// extended     metallic, spec_trans, spec_tint, sheen, sheen_tint, flatness, clearcoat, clearcoat_gloss
#include "render/bsdf/bsdf.h"

#include "render/bsdf/model/principled_terms.h"

namespace tessera::render::TESSERA_ISA {

namespace {

class PrincipledBsdf final : public Bsdf {
 public:
  PrincipledBsdf() : Bsdf(kSomeDiffuse) {}
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport transport, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport transport,
                    Mask active) const override;
  Float diffuse_share(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const override;
  Spectrum albedo(const BsdfParams& params) const override;
  void prepare(const TexturePoint& at, Mask lanes, BsdfParams& params) const override;
};

/// Generalised Trowbridge-Reitz with exponent 1, of the clear coat [Burley 2012]. Its tail falls so slowly
/// that the density over all normals is finite only thanks to the horizon.
struct Clearcoat {
  Float alpha2;

  TESSERA_INLINE explicit Clearcoat(const BsdfParams& params)
      : alpha2(sqr(lerp(params.extended[slot::kClearcoatGloss], Float(0.1f), Float(0.001f)))) {}

  /// D of the direction of `h` with squared length `h2`.
  TESSERA_INLINE Float density(Vec3 h, Float h2) const {
    const Float slope = fma(h.x, h.x, fma(h.y, h.y, alpha2 * sqr(h.z))) / h2;
    return (alpha2 - 1.0f) * kInvPi / (log(alpha2) * slope);
  }
  /// A normal with density D cos(theta).
  TESSERA_INLINE Vec3 sample(Vec2 u) const {
    const Float cos2 = (1.0f - exp((1.0f - u.y) * log(alpha2))) / (1.0f - alpha2);
    const Float sine = safe_sqrt(1.0f - cos2), phi = 2.0f * kPi * u.x;
    return {sine * cos(phi), sine * sin(phi), safe_sqrt(cos2)};
  }
  /// G1 of GGX with the fixed roughness that the model gives the coat's masking.
  static TESSERA_INLINE Float masking(Float z) {
    constexpr float kAlpha = 0.25f;
    return 2.0f * z / (z + sqrt(lerp(sqr(kAlpha), sqr(z), Float(1.0f))));
  }
};

/// The shares of the lobes and how likely each is to be sampled, at points seen along wo, mirrored to above
/// the surface.
struct Lobes {
  Mask inside;
  Float eta;          // of the other side over that of wo's
  Float glass, base;  // shares of the dielectric that transmits and of the diffuse base
  Float clearcoat;    // a quarter of the coat's weight
  Float scale;        // of the probabilities of `base`, `clearcoat` and of the microfacets

  TESSERA_INLINE Lobes(const BsdfParams& params, Mask below)
      : inside(below & params.with(kHasInside)),
        eta(select(inside, 1.0f / params.scalars[slot::kEta], params.scalars[slot::kEta])) {
    const Float dielectric = 1.0f - params.extended[slot::kMetallic];
    const Float spec_trans = params.extended[slot::kSpecTrans];
    glass = dielectric * spec_trans;
    base = select(inside, 0.0f, dielectric * (1.0f - spec_trans));
    clearcoat = select(inside, 0.0f, 0.25f * params.extended[slot::kClearcoat]);
    scale = 1.0f / (1.0f + base + clearcoat);
  }
  /// Probability of refraction at a microfacet of this Fresnel reflectance; inside there is nothing else.
  TESSERA_INLINE Float refraction(Float fresnel) const {
    return (1.0f - fresnel) * select(inside, 1.0f, glass);
  }
  /// ... and of reflection.
  TESSERA_INLINE Float reflection(Float fresnel) const { return 1.0f - refraction(fresnel); }
};

/// Reflectance of the microfacets: metal and tinted dielectric by Schlick's approximation.
Spectrum reflectance(const BsdfParams& params, const Lobes& lobes, Float cos_o, Float fresnel) {
  const Float metallic = params.extended[slot::kMetallic], tint = params.extended[slot::kSpecTint];
  const Float weight = schlick_weight(cos_o, lobes.eta);
  const Spectrum colour = params.spectra[slot::kReflectance];
  const Spectrum metal = lerp(weight, colour, Spectrum(1.0f));
  const Spectrum tinted = lerp(weight, tinted_normal_reflectance(params, colour, lobes.eta), Spectrum(1.0f));
  const Spectrum outside = metal * metallic + lerp(tint, Spectrum(fresnel), tinted) * (1.0f - metallic);
  return select(lobes.inside, Spectrum(lobes.glass * fresnel), outside);
}

/// f of the diffuse base and its sheen. `cos_i` is between wi and the half vector.
TESSERA_INLINE Spectrum base_value(const BsdfParams& params, const Lobes& lobes, Float zo, Float zi,
                                   Float cos_i) {
  const Spectrum colour = params.spectra[slot::kReflectance];
  Spectrum f = colour * (lobes.base * kInvPi * principled_diffuse(params, zo, zi, cos_i));
  f += principled_sheen(params, colour, cos_i) * (1.0f - params.extended[slot::kMetallic]);
  return f;
}

/// f cos and pdf of all lobes, for wo above the surface.
BsdfEval eval_above(const BsdfParams& params, const Lobes& lobes, Vec3 wo, Vec3 wi, Mask active) {
  const Mask reflected = wi.z > 0.0f;
  const Float zo = wo.z, zi = abs_cos_theta(wi);
  Vec3 h = fma(wi, select(reflected, 1.0f, lobes.eta), wo);
  h = select(h.z < 0.0f, -h, h);
  const Float oh = dot(wo, h), ih = dot(wi, h);
  const Mask facing = active & (oh > 0.0f) & (ih * wi.z > 0.0f);
  if (none(facing)) return {Spectrum(0.0f), 0.0f};
  const Float h2 = select(facing, length_squared(h), 1.0f), inverse = 1.0f / sqrt(h2);
  const Float cos_o = oh * inverse, cos_i = ih * inverse;
  const Float fresnel = fresnel_dielectric(cos_o, lobes.eta).reflectance;

  // The microfacets.
  const Microfacets facets = principled_facets(params, params.scalars[slot::kRoughness]);
  const Float so = facets.masking_length(wo), si = facets.masking_length({wi.x, wi.y, zi});
  const Float d = facets.density(h);
  const Float refraction = 2.0f * abs(oh * ih) / sqr(h2);  // Jacobian, as in dielectric.cpp
  const Float masked = d * zi / facets.masking_pair(so, zo, si, zi), visible = d / (zo + so);
  Spectrum transmitted;
  for (int c = 0; c < kSpectrumLanes; ++c)
    transmitted.c[c] = safe_sqrt(params.spectra[slot::kReflectance].c[c]);
  const Spectrum mirror =
      select_or_zero(fresnel > 0.0f, reflectance(params, lobes, cos_o, fresnel) * (0.5f * masked));
  transmitted *= lobes.glass * (1.0f - fresnel) * refraction * masked;
  BsdfEval result{select(reflected, mirror, transmitted),
                  select(reflected, lobes.reflection(fresnel) * lobes.scale * 0.5f * visible,
                         lobes.refraction(fresnel) * lobes.scale * refraction * sqr(lobes.eta) * visible)};

  // The coat and the base, from above only.
  const Mask outer = and_not(facing & reflected, lobes.inside);
  if (any(outer)) {
    const Clearcoat coat(params);
    const Float coat_density = coat.density(h, h2);
    const Float coat_reflectance = lerp(schlick_weight(cos_o, lobes.eta), Float(0.04f), Float(1.0f));
    const Float coat_f =
        lobes.clearcoat * coat_reflectance * coat_density * Clearcoat::masking(zo) * Clearcoat::masking(zi);
    const Spectrum f = base_value(params, lobes, zo, zi, cos_i);
    result.f_cos += select_or_zero(outer, (f + Spectrum(coat_f)) * zi);
    const Float coat_pdf = lobes.clearcoat * coat_density * h.z * inverse / (4.0f * max(cos_i, 1e-20f));
    result.pdf += select_or_zero(outer, lobes.scale * (coat_pdf + lobes.base * zi * kInvPi));
  }
  return {select_or_zero(facing, result.f_cos), select_or_zero(facing, result.pdf)};
}

}  // namespace

BsdfEval PrincipledBsdf::eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport transport,
                              Mask active) const {
  const Mask below = wo.z < 0.0f;
  const Lobes lobes(params, below);
  BsdfEval result = eval_above(params, lobes, mirror_if(below, wo), mirror_if(below, wi),
                               active & (wo.z != 0.0f) & (wi.z != 0.0f));
  result.f_cos = transported(transport, ~same_hemisphere(wo, wi), lobes.eta, result.f_cos);
  return result;
}

BsdfSample PrincipledBsdf::sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u,
                                  Transport transport, Mask active) const {
  const Mask below = wo.z < 0.0f;
  wo = mirror_if(below, wo);
  const Lobes lobes(params, below);
  active &= (wo.z > 0.0f) & ~(lobes.inside & (lobes.glass <= 0.0f));

  // Base, coat, refraction and reflection, in this order.
  const Vec3 wm = principled_facets(params, params.scalars[slot::kRoughness]).sample_visible(wo, u);
  const Float cos_m = dot(wo, wm);
  const DielectricFresnel fresnel = fresnel_dielectric(cos_m, lobes.eta);
  const Float to_base = lobes.base * lobes.scale, to_coat = to_base + lobes.clearcoat * lobes.scale;
  const Float to_refraction = to_coat + lobes.refraction(fresnel.reflectance) * lobes.scale;
  const Mask base = u_lobe < to_base, coat = and_not(u_lobe < to_coat, base);
  const Mask refracted = and_not(u_lobe < to_refraction, u_lobe < to_coat);
  Vec3 wi = reflect(wo, wm, cos_m);
  if (any(active & refracted)) wi = select(refracted, refract(wo, wm, cos_m, lobes.eta, fresnel), wi);
  if (any(active & coat)) {
    const Vec3 normal = Clearcoat(params).sample(u);
    wi = select(coat, reflect(wo, normal, dot(wo, normal)), wi);
  }
  if (any(active & base)) wi = select(base, square_to_cosine_hemisphere(u), wi);

  const Mask sided = (refracted & (wi.z < 0.0f)) | and_not(wi.z > 0.0f, refracted);
  const BsdfEval eval = eval_above(params, lobes, wo, wi, active & sided);
  const Mask valid = active & sided & (eval.pdf > 0.0f);
  return {.wi = mirror_if(below, wi),
          .weight = transported(transport, refracted, lobes.eta,
                                eval.f_cos * (1.0f / select(valid, eval.pdf, 1.0f))),
          .pdf = eval.pdf,
          .eta = select(refracted, lobes.eta, 1.0f),
          .valid = valid,
          .specular = Mask::none(),
          .transmission = refracted};
}

Float PrincipledBsdf::diffuse_share(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const {
  const Mask below = wo.z < 0.0f;
  wo = mirror_if(below, wo);
  wi = mirror_if(below, wi);
  const Lobes lobes(params, below);
  const Mask outer = and_not(active & (wo.z > 0.0f) & (wi.z > 0.0f), lobes.inside);
  if (none(outer)) return Float(0.0f);
  const Vec3 h = wo + wi;
  const Float cos_i = dot(wi, h) / sqrt(max(length_squared(h), 1e-20f));
  const Spectrum base = base_value(params, lobes, wo.z, wi.z, cos_i) * wi.z;
  return select_or_zero(outer, share_of(base, eval_above(params, lobes, wo, wi, outer).f_cos));
}

Spectrum PrincipledBsdf::albedo(const BsdfParams& params) const { return params.spectra[slot::kReflectance]; }

void PrincipledBsdf::prepare(const TexturePoint&, Mask lanes, BsdfParams& params) const {
  principled_index_of_specular(lanes, params);
}

const ModelOf<PrincipledBsdf> principled(BsdfKind::kPrincipled);

}  // namespace tessera::render::TESSERA_ISA
