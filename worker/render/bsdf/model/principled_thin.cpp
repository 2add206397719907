// Mitsuba 3's "principledthin", Disney's model for sheets without thickness [Burley 2015]: glass that
// reflects and lets through without bending, and a diffuse base that does both. Both sides are the same.
//
// spectra[0]   base colour
// scalars      roughness, anisotropic, eta: index of the sheet over the index around it
// extended     spec_trans, spec_tint, sheen, sheen_tint, flatness, diff_trans (0 to 2)
#include "render/bsdf/bsdf.h"

#include "render/bsdf/model/principled_terms.h"

namespace tessera::render::TESSERA_ISA {

namespace {

class PrincipledThinBsdf final : public Bsdf {
 public:
  PrincipledThinBsdf() : Bsdf(kSomeDiffuse) {}
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport transport, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport transport,
                    Mask active) const override;
  Float diffuse_share(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const override;
  Spectrum albedo(const BsdfParams& params) const override;
  void prepare(const TexturePoint& at, Mask lanes, BsdfParams& params) const override;
};

/// Shares of the lobes, which are also the probabilities of sampling them.
struct Lobes {
  Float glass;                   // half of it reflects, half transmits
  Float reflected, transmitted;  // of the diffuse base
  Float rough_reflection, rough_transmission;

  TESSERA_INLINE explicit Lobes(const BsdfParams& params)
      : glass(params.extended[slot::kSpecTrans]),
        reflected((1.0f - glass) * (1.0f - 0.5f * params.extended[slot::kDiffTrans])),
        transmitted((1.0f - glass) * 0.5f * params.extended[slot::kDiffTrans]),
        rough_reflection(params.scalars[slot::kRoughness]),
        // Two refractions spread light less than one reflection does [Burley 2015, fig. 15].
        rough_transmission((0.65f * params.scalars[slot::kEta] - 0.35f) * rough_reflection) {}

  TESSERA_INLINE Microfacets facets(const BsdfParams& params, Mask transmission) const {
    return principled_facets(params, select(transmission, rough_transmission, rough_reflection));
  }
};

/// f of the diffuse base. `cos_i` is between wi and the half vector.
TESSERA_INLINE Spectrum base_value(const BsdfParams& params, const Lobes& lobes, Mask reflection, Float zo,
                                   Float zi, Float cos_i) {
  const Spectrum colour = params.spectra[slot::kReflectance];
  const Spectrum scattered = colour * (lobes.reflected * kInvPi * principled_diffuse(params, zo, zi, cos_i)) +
                             principled_sheen(params, colour, cos_i) * lobes.reflected;
  return select(reflection, scattered, colour * (lobes.transmitted * kInvPi));
}

/// f cos and pdf of all lobes, for wo above the surface.
BsdfEval eval_above(const BsdfParams& params, const Lobes& lobes, Vec3 wo, Vec3 wi, Mask active) {
  const Mask reflection = wi.z > 0.0f;
  const Float zo = wo.z, zi = abs_cos_theta(wi);
  const Spectrum colour = params.spectra[slot::kReflectance];
  const Float eta = params.scalars[slot::kEta];

  // Glass transmits as if it reflected to the other side; microfacets must still be seen from below.
  const Vec3 mirrored{wi.x, wi.y, zi};
  const Vec3 h = wo + mirrored;
  const Float inverse = 1.0f / sqrt(max(length_squared(h), 1e-20f));
  const Float cos_o = dot(wo, h) * inverse, cos_i = dot(wi, h) * inverse;
  const Mask facing = reflection | (cos_i < 0.0f);
  const Microfacets facets = lobes.facets(params, ~reflection);
  const Float so = facets.masking_length(wo), si = facets.masking_length(mirrored);
  const Float half_density = select_or_zero(facing, 0.5f * facets.density(h));
  const Float fresnel = fresnel_dielectric(cos_o, eta).reflectance;
  const Spectrum tinted =
      lerp(schlick_weight(cos_o, eta), tinted_normal_reflectance(params, colour, eta), Spectrum(1.0f));
  const Spectrum mirror = lerp(params.extended[slot::kSpecTint], Spectrum(fresnel), tinted);
  Spectrum f_cos = select(reflection, mirror, colour * (1.0f - fresnel)) *
                   (lobes.glass * half_density * zi / facets.masking_pair(so, zo, si, zi));
  Float pdf = 0.5f * lobes.glass * half_density / (zo + so);

  // The base.
  f_cos += base_value(params, lobes, reflection, zo, zi, cos_i) * zi;
  pdf += select(reflection, lobes.reflected, lobes.transmitted) * zi * kInvPi;
  return {select_or_zero(active, f_cos), select_or_zero(active, pdf)};
}

}  // namespace

BsdfEval PrincipledThinBsdf::eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport, Mask active) const {
  const Mask below = wo.z < 0.0f;
  return eval_above(params, Lobes(params), mirror_if(below, wo), mirror_if(below, wi),
                    active & (wo.z != 0.0f) & (wi.z != 0.0f));
}

BsdfSample PrincipledThinBsdf::sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport,
                                      Mask active) const {
  const Mask below = wo.z < 0.0f;
  wo = mirror_if(below, wo);
  const Lobes lobes(params);

  // Reflection and transmission by the glass, then by the base.
  const Mask glass = u_lobe < lobes.glass;
  const Mask transmission =
      (glass & (u_lobe >= 0.5f * lobes.glass)) | (u_lobe >= lobes.glass + lobes.reflected);
  Vec3 wi = square_to_cosine_hemisphere(u), wm{0.0f, 0.0f, 1.0f};
  if (any(active & glass)) {
    wm = select(glass, lobes.facets(params, transmission).sample_visible(wo, u), wm);
    wi = select(glass, reflect(wo, wm, dot(wo, wm)), wi);
  }
  const Mask reflected = wi.z > 0.0f;
  wi.z = select(transmission, -wi.z, wi.z);
  // eval_above() knows of no glass that transmits to where its microfacet is not seen from below.
  const Mask scattered = reflected & (~transmission | (dot(wi, wm) < 0.0f));

  const BsdfEval eval = eval_above(params, lobes, wo, wi, active & scattered);
  const Mask valid = active & scattered & (wo.z > 0.0f) & (eval.pdf > 0.0f);
  return {.wi = mirror_if(below, wi),
          .weight = eval.f_cos * (1.0f / select(valid, eval.pdf, 1.0f)),
          .pdf = eval.pdf,
          .eta = 1.0f,
          .valid = valid,
          .specular = Mask::none(),
          .transmission = transmission};
}

Float PrincipledThinBsdf::diffuse_share(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const {
  const Mask below = wo.z < 0.0f;
  wo = mirror_if(below, wo);
  wi = mirror_if(below, wi);
  const Lobes lobes(params);
  const Mask reflection = wi.z > 0.0f;
  const Float zi = abs_cos_theta(wi);
  const Vec3 h{wo.x + wi.x, wo.y + wi.y, wo.z + zi};
  const Float cos_i = dot(wi, h) / sqrt(max(length_squared(h), 1e-20f));
  const Spectrum base = base_value(params, lobes, reflection, wo.z, zi, cos_i) * zi;
  return share_of(base, eval_above(params, lobes, wo, wi, active).f_cos);
}

Spectrum PrincipledThinBsdf::albedo(const BsdfParams& params) const {
  return params.spectra[slot::kReflectance];
}

void PrincipledThinBsdf::prepare(const TexturePoint&, Mask lanes, BsdfParams& params) const {
  principled_index_of_specular(lanes, params);
}

const ModelOf<PrincipledThinBsdf> principled_thin(BsdfKind::kPrincipledThin);

}  // namespace tessera::render::TESSERA_ISA
