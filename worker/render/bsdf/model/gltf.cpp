// The layers of glTF 2.0 [specification, appendix B; KHR_materials_ior, specular, transmission, volume,
// clearcoat, sheen, anisotropy and diffuse_transmission]: microfacets that are a metal and a dielectric in
// proportions, with Schlick's reflectance; under the dielectric a Lambertian base, or refraction; sheen and a
// clear coat above. From inside (kHasInside) there is only the glass; otherwise both sides are the same.
//
// The appendix gives the base what 1 - F of the half vector leaves, and leaves it open how energy is kept.
// Here the layers share light by their directional albedo, as renderers of glTF do for light from all around:
// the base has the factor (1 - E(wo)) (1 - E(wi)) / (1 - mean E) [Kelemen & Szirmay-Kalos 2001], and light
// between the facets is given back [Kulla & Conty 2017]. All of it is reciprocal, and a white surface returns
// all light.
//
// spectra      base colour, colour of the dielectric's reflectance
// scalars      roughness, anisotropic, eta: index below the surface over the index above
// extended     metallic, transmission, specular, coat, coat roughness, sheen roughness, rotation (radians),
//              share of the base that is transmitted; colours: sheen, what the base transmits
#include "render/bsdf/models.h"

#include "render/bsdf/model/principled_terms.h"
#include "render/bsdf/tables/layer_table.h"

namespace tessera::render::TESSERA_ISA {

namespace {

class GltfBsdf final : public Bsdf {
 public:
  GltfBsdf() : Bsdf(kSomeDiffuse) {}
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport transport, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport transport,
                    Mask active) const override;
  Float diffuse_share(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const override;
  Spectrum albedo(const BsdfParams& params) const override;
};

constexpr float kCoatReflectance = 0.04f;  // along the normal: index 1.5

/// Energies of layers of one roughness [layer_table.h].
struct LayerEnergy {
  Float normal, grazing, sheen;

  TESSERA_INLINE Float mirror() const { return normal + grazing; }
  TESSERA_INLINE Spectrum of(Spectrum f0, Float f90) const { return f0 * normal + Spectrum(f90 * grazing); }
  TESSERA_INLINE Float of(Float f0, Float f90) const { return f0 * normal + f90 * grazing; }
};

/// The rows of the layer table for one roughness of each lane.
class LayerRows {
 public:
  TESSERA_INLINE LayerRows(const BsdfParams& params, Float roughness, Mask lanes)
      : table_(params.coat_tables), offset_(params.coat_table), lanes_(lanes) {
    const Float position = clamp(roughness, 0.0f, 1.0f) * (kLayerRows - 1.0f);
    const Float low = min(floor(position), kLayerRows - 2.0f);
    row_ = to_int(low);
    t_ = position - low;
  }

  /// Of light at a cosine to the normal.
  TESSERA_INLINE LayerEnergy at(Float cosine) const {
    const Float position = clamp(sqrt(max(cosine, 0.0f)), 0.0f, 1.0f) * (kLayerColumns - 1.0f);
    const Float low = min(floor(position), kLayerColumns - 2.0f), t = position - low;
    const Int entry = row_ * kLayerColumns + to_int(low) + kLayerRows;
    return mixed(t_, mixed(t, load(entry), load(entry + 1)),
                 mixed(t, load(entry + kLayerColumns), load(entry + (kLayerColumns + 1))));
  }
  /// Of diffuse light.
  TESSERA_INLINE LayerEnergy mean() const { return mixed(t_, load(row_), load(row_ + 1)); }

 private:
  TESSERA_INLINE LayerEnergy load(Int entry) const {
    const Float4 values = gather4(table_, offset_ + entry * kLayerEntry, lanes_);
    return {values.c[0], values.c[1], values.c[2]};
  }
  static TESSERA_INLINE LayerEnergy mixed(Float t, const LayerEnergy& a, const LayerEnergy& b) {
    return {lerp(t, a.normal, b.normal), lerp(t, a.grazing, b.grazing), lerp(t, a.sheen, b.sheen)};
  }

  const float* table_;
  Int offset_;
  Mask lanes_;
  Int row_;
  Float t_;
};

/// The light that is scattered between the facets, as a part of what single scattering loses: the geometric
/// series of the mean reflectance and of what diffuse light loses [Kulla & Conty 2017].
TESSERA_INLINE Float between_facets(Float f0, Float f90, Float kept) {
  const Float mean = f0 + (f90 - f0) * (1.0f / 21);  // of Schlick's reflectance, over diffuse light
  return sqr(mean) * kept / max(1.0f - mean * (1.0f - kept), 1e-6f);
}

/// GGX with glTF's roughness.
TESSERA_INLINE Ggx coat_facets(const BsdfParams& params) {
  const Float alpha = max(sqr(params.extended[slot::kCoatRoughness]), kLeastLayerAlpha);
  return {alpha, alpha};
}

/// What follows from the parameters and wo, mirrored to above the surface: reflectances, shares, and how
/// likely each lobe is to be sampled.
struct Layers {
  Mask inside;
  Float eta;  // of the other side over that of wo's
  Ggx facets;
  Spectrum base;                 // base colour
  Spectrum dielectric0, f0;      // reflectance along the normal, of the dielectric and of all
  Float dielectric90, f90;       // ... and along the surface
  Float metal, share;            // of the facets: metal, and dielectric
  Float glass, diffuse, behind;  // shares: what refracts, the base, and its part that transmits
  Float coat, weakest;           // the coat's weight, the largest component of dielectric0
  Spectrum sheen;
  LayerRows rows, coat_rows, sheen_rows;
  LayerEnergy mean, out;              // of the facets: over diffuse light, along wo
  Float coat_out, sheen_out;          // what coat and sheen reflect of light along wo
  Float to_above, to_below, to_coat;  // probabilities; the rest goes to the facets

  TESSERA_INLINE Layers(const BsdfParams& params, Vec3 wo, Mask below, Mask active)
      : inside(below & params.with(kHasInside)),
        eta(select(inside, 1.0f / params.scalars[slot::kEta], params.scalars[slot::kEta])),
        facets(facets_of(params)),
        base(clamp(params.spectra[slot::kReflectance], 0.0f, 1.0f)),
        rows(params, sqrt(sqrt(facets.alpha_x * facets.alpha_y)), active),
        coat_rows(params, params.extended[slot::kCoatRoughness], active),
        sheen_rows(params, params.extended[slot::kSheenRoughness], active) {
    metal = select(inside, 0.0f, params.extended[slot::kMetallic]);
    const Float other = 1.0f - params.extended[slot::kMetallic];
    glass = other * params.extended[slot::kTransmission];
    diffuse = select(inside, 0.0f, other - glass);
    behind = select(params.with(kHasInside), 0.0f, params.extended[slot::kBehind]);
    dielectric90 = params.extended[slot::kSpecular];
    const Float normal = sqr((eta - 1.0f) / (eta + 1.0f));
    for (int c = 0; c < kSpectrumLanes; ++c)
      dielectric0.c[c] = min(normal * params.spectra[slot::kSpecularColor].c[c], 1.0f) * dielectric90;
    share = select(inside, glass, 1.0f - metal);
    f0 = dielectric0 * share + base * metal;
    f90 = dielectric90 * share + metal;
    weakest = dielectric0.max_component();
    coat = params.extended[slot::kCoat];
    sheen = clamp(params.extended_spectra[slot::kSheenColor], 0.0f, 1.0f);

    mean = rows.mean();
    out = rows.at(wo.z);
    coat_out = coat_energy(wo, inside);
    sheen_out = select(inside, 0.0f, sheen_rows.at(wo.z).sheen);
    const Float sheen_kept = min(sheen_out, 1.0f);
    const Float reflected = out.of(f0, f90).mean();
    const Float refracted = glass * (1.0f - min(out.of(weakest, dielectric90), 1.0f)) * base.mean();
    const Float even = diffuse * base_factor(out);
    const Float above = even * (1.0f - behind) * base.mean() +
                        select(inside, 0.0f, (1.0f - out.mirror()) * f90 + sheen_kept * sheen.mean());
    const Float under = even * behind * behind_color(params).mean();
    const Float scale = (1.0f - coat_out) / max(reflected + refracted + above + under, 1e-6f);
    to_above = select(inside, 0.0f, above * scale);
    to_below = select(inside, 0.0f, under * scale);
    to_coat = coat_out;
  }

  static TESSERA_INLINE Ggx facets_of(const BsdfParams& params) {
    const Float alpha = max(sqr(params.scalars[slot::kRoughness]), kLeastLayerAlpha);
    return {lerp(sqr(params.scalars[slot::kAnisotropic]), alpha, Float(1.0f)), alpha};
  }
  static TESSERA_INLINE Spectrum behind_color(const BsdfParams& params) {
    return clamp(params.extended_spectra[slot::kBehindColor], 0.0f, 1.0f);
  }
  /// The share that the coat reflects along a direction; where `under` it is not met.
  TESSERA_INLINE Float coat_energy(Vec3 w, Mask under) const {
    return select_or_zero(and_not(coat > 0.0f, under),
                          coat * coat_rows.at(abs_cos_theta(w)).of(Float(kCoatReflectance), Float(1.0f)));
  }
  /// The share that the dielectric leaves to the base, along a direction.
  TESSERA_INLINE Float base_factor(const LayerEnergy& energy) const {
    const Float extra = (1.0f - energy.mirror()) * between_facets(weakest, dielectric90, mean.mirror());
    return max(1.0f - energy.of(weakest, dielectric90) - extra, 0.0f);
  }
  /// The rest of the probability, of facets with this reflectance: of reflection at them.
  TESSERA_INLINE Float reflection(Spectrum all, Spectrum dielectric) const {
    const Float reflected = all.mean(),
                refracted = glass * (1.0f - min(dielectric.mean(), 1.0f)) * base.mean();
    return select(refracted > 0.0f, reflected / max(reflected + refracted, 1e-20f), 1.0f);
  }
  TESSERA_INLINE Float to_facets() const { return 1.0f - to_above - to_below - to_coat; }
};

TESSERA_INLINE Spectrum schlick(Float weight, Spectrum f0, Float f90) {
  return f0 * (1.0f - weight) + Spectrum(f90 * weight);
}

/// f cos of the sheen [Estevez & Kulla 2017; its masking as glTF has it: Ashikhmin & Premoze 2007].
TESSERA_INLINE Float sheen_value(const BsdfParams& params, Vec3 wo, Vec3 wi, Float h2, Vec3 h) {
  const Float roughness = max(params.extended[slot::kSheenRoughness], kLeastSheenRoughness);
  const Float inverse = 1.0f / sqr(roughness);
  const Float sin2 = clamp(fma(h.x, h.x, sqr(h.y)) / h2, 1e-12f, 1.0f);
  const Float density = (2.0f + inverse) * exp(0.5f * inverse * log(sin2)) * (0.5f * kInvPi);
  return density * wi.z / (4.0f * max(fma(-wo.z, wi.z, wo.z + wi.z), 1e-6f));
}

struct LayeredEval {
  BsdfEval all;
  Spectrum even;  // f cos of the base alone
};

/// For wo above the surface.
LayeredEval eval_above(const BsdfParams& params, const Layers& layers, Vec3 wo, Vec3 wi, Mask active) {
  const Mask reflected = wi.z > 0.0f, volume = params.with(kHasInside);
  const Mask refracted = and_not(volume, reflected);
  const Float zo = wo.z, zi = abs_cos_theta(wi);
  const Vec3 mirrored{wi.x, wi.y, zi};
  Vec3 h = wo + select(refracted, wi * layers.eta, mirrored);
  h = select(h.z < 0.0f, -h, h);
  const Float oh = dot(wo, h), ih = dot(select(refracted, wi, mirrored), h);
  const Mask facing = active & (oh > 0.0f) & (select(refracted, -ih, ih) > 0.0f);
  const Float h2 = select(facing, length_squared(h), 1.0f), inverse = 1.0f / sqrt(h2);
  const Float cos_o = oh * inverse;

  // The facets.
  const Float weight = schlick_weight(cos_o, layers.eta);
  const Spectrum all = schlick(weight, layers.f0, layers.f90),
                 dielectric = schlick(weight, layers.dielectric0, layers.dielectric90);
  const Float so = layers.facets.masking_length(wo), si = layers.facets.masking_length(mirrored);
  const Float d = select_or_zero(facing, layers.facets.density(h));
  const Float masked = d * zi / layers.facets.masking_pair(so, zo, si, zi), visible = d / (zo + so);
  // The Jacobian: of reflection, or of refraction as in dielectric.cpp.
  const Float jacobian = select(refracted, 2.0f * abs(oh * ih) / sqr(h2), 0.5f);
  const Spectrum through = layers.base * (Spectrum(1.0f) - clamp(dielectric, 0.0f, 1.0f)) * layers.glass;
  const Float to_mirror = layers.reflection(all, dielectric);
  Spectrum f_cos = select(reflected, all, through) * (jacobian * masked);
  Float pdf = layers.to_facets() * select(reflected, to_mirror, 1.0f - to_mirror) * jacobian * visible *
              select(refracted, sqr(layers.eta), 1.0f);

  // What is even: the base, and light between the facets.
  const Mask outer = and_not(active, layers.inside | refracted);
  const LayerEnergy in = layers.rows.at(zi);
  const Float mean_factor = max(layers.base_factor(layers.mean), 1e-6f);
  const Float even = layers.diffuse * layers.base_factor(layers.out) * layers.base_factor(in) / mean_factor;
  const Spectrum base =
      select(reflected, layers.base * (1.0f - layers.behind), Layers::behind_color(params) * layers.behind) *
      (even * zi * kInvPi);
  const Float lost = (1.0f - layers.out.mirror()) * (1.0f - in.mirror()) /
                     max(1.0f - layers.mean.mirror(), 1e-6f) * zi * kInvPi;
  Spectrum between;
  for (int c = 0; c < kSpectrumLanes; ++c)
    between.c[c] =
        lost *
        (layers.share * between_facets(layers.dielectric0.c[c], layers.dielectric90, layers.mean.mirror()) +
         layers.metal * between_facets(layers.base.c[c], Float(1.0f), layers.mean.mirror()));
  f_cos += select_or_zero(outer, base + select_or_zero(reflected, between));
  Spectrum diffuse = select_or_zero(outer, base);
  pdf += select_or_zero(outer, select(reflected, layers.to_above, layers.to_below) * zi * kInvPi);

  // Sheen, and the coat.
  const Mask under = (layers.inside & reflected) | and_not(refracted, layers.inside);  // where wi is
  const Mask outside = and_not(reflected, layers.inside);
  if (any(active & (layers.sheen.max_component() > 0.0f))) {
    const Float colour = layers.sheen.max_component();
    const Float sheen_in = select(under, 0.0f, layers.sheen_rows.at(zi).sheen);
    // Along the surface the lobe alone would reflect several times the light that comes.
    const Float most = max(layers.sheen_out, sheen_in), left = 1.0f - colour * min(most, 1.0f);
    f_cos *= left, diffuse *= left;
    const Float kept = sheen_value(params, wo, wi, h2, h) / max(most, 1.0f);
    f_cos += select_or_zero(outside, layers.sheen * kept);
  }
  if (any(active & (layers.coat > 0.0f))) {
    const Float left = (1.0f - layers.coat_out) * (1.0f - layers.coat_energy(wi, under));
    f_cos *= left, diffuse *= left;
    const Ggx facets = coat_facets(params);
    const Float coat_so = facets.masking_length(wo), coat_si = facets.masking_length(mirrored);
    const Float coat_d = select_or_zero(facing & outside, 0.5f * facets.density(h));
    const Float fresnel = lerp(schlick_power(cos_o), Float(kCoatReflectance), Float(1.0f));
    f_cos += Spectrum(layers.coat * fresnel * coat_d * zi / facets.masking_pair(coat_so, zo, coat_si, zi));
    pdf += layers.to_coat * coat_d / (zo + coat_so);
  }
  return {{select_or_zero(active, f_cos), select_or_zero(active, pdf)}, select_or_zero(active, diffuse)};
}

/// Between the shading frame and the one along the direction of the anisotropy.
struct Turn {
  Float cosine, sine;

  TESSERA_INLINE explicit Turn(const BsdfParams& params) : cosine(1.0f), sine(0.0f) {
    if ((params.some_flags & kAnisotropic) == 0) return;
    cosine = cos(params.extended[slot::kRotation]), sine = sin(params.extended[slot::kRotation]);
  }
  TESSERA_INLINE Vec3 into(Vec3 w) const {
    return {fma(cosine, w.x, sine * w.y), fma(cosine, w.y, -sine * w.x), w.z};
  }
  TESSERA_INLINE Vec3 back(Vec3 w) const {
    return {fma(cosine, w.x, -sine * w.y), fma(cosine, w.y, sine * w.x), w.z};
  }
};

}  // namespace

BsdfEval GltfBsdf::eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport transport, Mask active) const {
  const Mask below = wo.z < 0.0f;
  const Turn turn(params);
  wo = turn.into(wo), wi = turn.into(wi);
  active &= (wo.z != 0.0f) & (wi.z != 0.0f);
  const Vec3 o = mirror_if(below, wo), i = mirror_if(below, wi);
  const Layers layers(params, o, below, active);
  BsdfEval result = eval_above(params, layers, o, i, active).all;
  const Mask refracted = and_not(params.with(kHasInside), same_hemisphere(wo, wi));
  result.f_cos = transported(transport, refracted, layers.eta, result.f_cos);
  return result;
}

BsdfSample GltfBsdf::sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport transport,
                            Mask active) const {
  const Mask below = wo.z < 0.0f, volume = params.with(kHasInside);
  const Turn turn(params);
  wo = mirror_if(below, turn.into(wo));
  active &= wo.z > 0.0f;
  const Layers layers(params, wo, below, active);
  active &= ~(layers.inside & (layers.glass <= 0.0f));

  // Base to above, base to below, coat, reflection, and what goes through, in this order.
  const Vec3 wm = layers.facets.sample_visible(wo, u);
  const Float cos_m = dot(wo, wm);
  const Float weight = schlick_weight(cos_m, layers.eta);
  const Float to_mirror = layers.reflection(schlick(weight, layers.f0, layers.f90),
                                            schlick(weight, layers.dielectric0, layers.dielectric90));
  const Float after_above = layers.to_above, after_below = after_above + layers.to_below;
  const Float after_coat = after_below + layers.to_coat;
  const Mask even = u_lobe < after_below, coat = and_not(u_lobe < after_coat, even);
  const Mask through = u_lobe >= after_coat + layers.to_facets() * to_mirror;
  const Mask to_below = and_not(even, u_lobe < after_above) | through;
  const Mask refracted = through & volume;
  Vec3 wi = reflect(wo, wm, cos_m);
  if (any(active & refracted)) {
    const DielectricFresnel fresnel = fresnel_dielectric(cos_m, layers.eta);
    wi = select(refracted, refract(wo, wm, cos_m, layers.eta, fresnel), wi);
    active &= ~(refracted & (fresnel.eta_cos_t <= 0.0f));
  }
  if (any(active & coat)) {
    const Vec3 normal = coat_facets(params).sample_visible(wo, u);
    wi = select(coat, reflect(wo, normal, dot(wo, normal)), wi);
  }
  if (any(active & even)) wi = select(even, square_to_cosine_hemisphere(u), wi);
  // A sheet lets light through as if it reflected to the other side.
  active &= select(refracted, -wi.z, wi.z) > 0.0f;
  wi.z = select(and_not(to_below, refracted), -wi.z, wi.z);

  const BsdfEval eval = eval_above(params, layers, wo, wi, active).all;
  const Mask valid = active & (eval.pdf > 0.0f);
  return {.wi = turn.back(mirror_if(below, wi)),
          .weight = transported(transport, refracted, layers.eta,
                                eval.f_cos * (1.0f / select(valid, eval.pdf, 1.0f))),
          .pdf = eval.pdf,
          .eta = select(refracted, layers.eta, 1.0f),
          .valid = valid,
          .specular = Mask::none(),
          .transmission = to_below};
}

Float GltfBsdf::diffuse_share(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const {
  const Mask below = wo.z < 0.0f;
  const Turn turn(params);
  wo = mirror_if(below, turn.into(wo)), wi = mirror_if(below, turn.into(wi));
  active &= (wo.z > 0.0f) & (wi.z != 0.0f);
  const LayeredEval eval = eval_above(params, Layers(params, wo, below, active), wo, wi, active);
  return select_or_zero(active, share_of(eval.even, eval.all.f_cos));
}

Spectrum GltfBsdf::albedo(const BsdfParams& params) const { return params.spectra[slot::kReflectance]; }

const Bsdf& gltf_bsdf() {
  static const GltfBsdf model;
  return model;
}

}  // namespace tessera::render::TESSERA_ISA
