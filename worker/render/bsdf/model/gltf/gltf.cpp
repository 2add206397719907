// The layers of glTF 2.0 [specification, appendix B; KHR_materials_ior, specular, transmission, volume,
// clearcoat, sheen, anisotropy, diffuse_transmission, iridescence and dispersion]: microfacets that are a
// metal and a dielectric in proportions, with Schlick's reflectance, in part under a thin film; under the
// dielectric a Lambertian base, or refraction; sheen and a clear coat above. From inside (kHasInside) there
// is only the glass; otherwise both sides are the same.
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
// further      film: share, index, thickness (nm); half the spread of the indices; direction of the
// anisotropy
#include "render/bsdf/bsdf.h"
#include "render/bsdf/model/gltf/layers.h"

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
  void prepare(const TexturePoint& at, Mask lanes, BsdfParams& params) const override;
};

/// f cos of the sheen [Estevez & Kulla 2017; its masking as glTF has it: Ashikhmin & Premoze 2007].
TESSERA_INLINE Float sheen_value(const BsdfParams& params, Vec3 wo, Vec3 wi, Float h2, Vec3 h) {
  const Float roughness = max(params.extended[slot::kSheenRoughness], kLeastSheenRoughness);
  const Float inverse = 1.0f / sqr(roughness);
  const Float sin2 = clamp(fma(h.x, h.x, sqr(h.y)) / h2, 1e-12f, 1.0f);
  const Float density = (2.0f + inverse) * exp(0.5f * inverse * log(sin2)) * (0.5f * kInvPi);
  return density * wi.z / (4.0f * max(fma(-wo.z, wi.z, wo.z + wi.z), 1e-6f));
}

/// The normal that scatters wo to wi, for both of unit length.
struct HalfVector {
  Vec3 h;        // upwards, of any length
  Float oh, ih;  // cosines times the length
  Mask facing;   // wo and wi see the side of the facet that they have to
  Float h2, cos_o;

  TESSERA_INLINE HalfVector(Vec3 wo, Vec3 wi, Mask refracted, Float eta, Mask active) {
    const Vec3 mirrored{wi.x, wi.y, abs_cos_theta(wi)};
    h = wo + select(refracted, wi * eta, mirrored);
    h = select(h.z < 0.0f, -h, h);
    oh = dot(wo, h), ih = dot(select(refracted, wi, mirrored), h);
    facing = active & (oh > 0.0f) & (select(refracted, -ih, ih) > 0.0f);
    h2 = select(facing, length_squared(h), 1.0f);
    cos_o = oh * (1.0f / sqrt(h2));
  }
  /// That of reflection, or of refraction as in dielectric.cpp.
  TESSERA_INLINE Float jacobian(Mask refracted) const {
    return select(refracted, 2.0f * abs(oh * ih) / sqr(h2), 0.5f);
  }
};

/// Lengths of Smith's masking, for wo and for wi mirrored to above the surface.
struct Masking {
  Float so, zo, si, zi;

  TESSERA_INLINE Masking(const Ggx& facets, Vec3 wo, Vec3 wi)
      : so(facets.masking_length(wo)),
        zo(wo.z),
        si(facets.masking_length({wi.x, wi.y, abs_cos_theta(wi)})),
        zi(abs_cos_theta(wi)) {}
  /// f cos, and the density of visible normals, without the Jacobian for facets of density d.
  TESSERA_INLINE Float value(const Ggx& facets, Float d) const {
    return d * zi / facets.masking_pair(so, zo, si, zi);
  }
  TESSERA_INLINE Float visible(Float d) const { return d / (zo + so); }
};

/// Refraction by an index for each channel, of which sample() takes any with the same probability.
BsdfEval eval_dispersed(const Layers& layers, Vec3 wo, Vec3 wi, Mask refracted) {
  BsdfEval result{Spectrum(0.0f), Float(0.0f)};
  const Masking masking(layers.facets, wo, wi);
  for (int c = 0; c < kSpectrumLanes; ++c) {
    const Float eta = layers.etas.c[c];
    const HalfVector half(wo, wi, refracted, eta, refracted);
    const FacetReflectance at = layers.reflectance(half.cos_o);
    const Float d = select_or_zero(half.facing, layers.facets.density(half.h)) * half.jacobian(refracted);
    const Float through = layers.base.c[c] * (1.0f - clamp(at.dielectric.c[c], 0.0f, 1.0f)) * layers.glass;
    result.f_cos.c[c] = through * masking.value(layers.facets, d);
    result.pdf = fma((1.0f - layers.reflection(at)) * sqr(eta), masking.visible(d), result.pdf);
  }
  result.pdf = result.pdf * (1.0f / kSpectrumLanes) * layers.to_facets();
  return result;
}

/// The coat, for wo and wi above the surface.
BsdfEval eval_coat(const BsdfParams& params, const Layers& layers, Vec3 wo, Vec3 wi, Float cos_o,
                   Transport transport, Mask lit) {
  const Vec3 o = layers.coat_frame.to_local(wo), i = layers.coat_frame.to_local(wi);
  if (layers.coat_frame.tilted) lit &= (o.z > 0.0f) & (i.z > 0.0f);
  const Ggx facets = coat_facets(params);
  const Masking masking(facets, o, i);
  const Float d = select_or_zero(lit, 0.5f * facets.density(o + i));
  const Float fresnel = lerp(schlick_power(cos_o), Float(Layers::kCoatReflectance), Float(1.0f));
  Float f_cos = layers.coat * fresnel * masking.value(facets, d);
  // The coat scatters radiance as a surface with its normal does, and importance as radiance the other way
  // round.
  if (layers.coat_frame.tilted && transport == Transport::kImportance)
    f_cos = f_cos * select(lit, wi.z * o.z / (i.z * wo.z), 1.0f);
  return {Spectrum(f_cos), layers.to_coat * masking.visible(d)};
}

struct LayeredEval {
  BsdfEval all;
  Spectrum even;  // f cos of the base alone
};

/// For wo above the surface.
LayeredEval eval_above(const BsdfParams& params, const Layers& layers, Vec3 wo, Vec3 wi, Transport transport,
                       Mask active) {
  const Mask reflected = wi.z > 0.0f, volume = params.with(kHasInside);
  const Mask refracted = and_not(volume, reflected);
  const Float zi = abs_cos_theta(wi);
  const HalfVector half(wo, wi, refracted, layers.eta, active);

  // The facets.
  const FacetReflectance at = layers.reflectance(half.cos_o);
  const Masking masking(layers.facets, wo, wi);
  const Float d = select_or_zero(half.facing, layers.facets.density(half.h));
  const Float jacobian = half.jacobian(refracted);
  const Spectrum through = layers.base * (Spectrum(1.0f) - clamp(at.dielectric, 0.0f, 1.0f)) * layers.glass;
  const Float to_mirror = layers.reflection(at);
  Spectrum f_cos = select(reflected, at.all, through) * (jacobian * masking.value(layers.facets, d));
  Float pdf = layers.to_facets() * select(reflected, to_mirror, 1.0f - to_mirror) * jacobian *
              masking.visible(d) * select(refracted, sqr(layers.eta), 1.0f);
  if (layers.disperses && any(active & refracted)) {
    const BsdfEval dispersed = eval_dispersed(layers, wo, wi, active & refracted);
    f_cos = select(refracted, dispersed.f_cos, f_cos);
    pdf = select(refracted, dispersed.pdf, pdf);
  }

  // Even light: the base, and light between the facets.
  const Mask outer = and_not(active, layers.inside | refracted);
  const LayerEnergy in = layers.rows.at(zi);
  const LayerShare mean_factor = max(layers.mean_base_factor(), 1e-6f);
  const LayerShare even = layers.diffuse * layers.base_out * layers.base_factor(zi, in) / mean_factor;
  const Spectrum base =
      select(reflected, layers.base * (1.0f - layers.behind), Layers::behind_color(params) * layers.behind) *
      (even * zi * kInvPi);
  const Float lost = (1.0f - layers.out.mirror()) * (1.0f - in.mirror()) /
                     max(1.0f - layers.mean.mirror(), 1e-6f) * zi * kInvPi;
  f_cos += select_or_zero(outer, base + select_or_zero(reflected, layers.between() * lost));
  Spectrum diffuse = select_or_zero(outer, base);
  pdf += select_or_zero(outer, select(reflected, layers.to_above, layers.to_below) * zi * kInvPi);

  // Sheen, and the coat.
  const Mask under = (layers.inside & reflected) | and_not(refracted, layers.inside);  // where wi is
  const Mask outside = and_not(reflected, layers.inside);
  if (any(active & (layers.sheen.max_component() > 0.0f))) {
    const LayerShare colour = layer_share(layers.sheen);
    const Float sheen_in = select(under, 0.0f, layers.sheen_rows.at(zi).sheen);
    // Along the surface the lobe alone would reflect several times the light that comes.
    const Float most = max(layers.sheen_out, sheen_in);
    const LayerShare left = LayerShare(1.0f) - colour * min(most, 1.0f);
    f_cos *= left, diffuse *= left;
    const Float kept = sheen_value(params, wo, wi, half.h2, half.h) / max(most, 1.0f);
    f_cos += select_or_zero(outside, layers.sheen * kept);
  }
  if (any(active & (layers.coat > 0.0f))) {
    const Float left = (1.0f - layers.coat_out) * (1.0f - layers.coat_energy(wi, ~reflected, under));
    f_cos *= left, diffuse *= left;
    const BsdfEval coat = eval_coat(params, layers, wo, wi, half.cos_o, transport, half.facing & outside);
    f_cos += coat.f_cos, pdf += coat.pdf;
  }
  return {{select_or_zero(active, f_cos), select_or_zero(active, pdf)}, select_or_zero(active, diffuse)};
}

/// Between the shading frame and the one along the direction of the anisotropy.
struct Turn {
  Float cosine, sine;

  TESSERA_INLINE explicit Turn(const BsdfParams& params) : cosine(1.0f), sine(0.0f) {
    if ((params.some_flags & kAnisotropic) == 0) return;
    cosine = cos(params.extended[slot::kRotation]), sine = sin(params.extended[slot::kRotation]);
    if ((params.some_flags & kUsesFurther) != 0) turn_on(params);
  }
  TESSERA_INLINE Vec3 into(Vec3 w) const {
    return {fma(cosine, w.x, sine * w.y), fma(cosine, w.y, -sine * w.x), w.z};
  }
  TESSERA_INLINE Vec3 back(Vec3 w) const {
    return {fma(cosine, w.x, -sine * w.y), fma(cosine, w.y, sine * w.x), w.z};
  }

 private:
  /// By the direction that a texture has.
  TESSERA_INLINE void turn_on(const BsdfParams& params) {
    const Vec3 encoded = vec3_of(params.further_colors[slot::kAnisotropyDirection]);
    const Float x = 2.0f * encoded.x - 1.0f, y = 2.0f * encoded.y - 1.0f, l2 = fma(x, x, sqr(y));
    const Mask usable = params.with(kUsesFurther) & (l2 > 0.0f);
    const Float scale = 1.0f / sqrt(select(usable, l2, 1.0f));
    const Float c = select(usable, x * scale, 1.0f), s = select(usable, y * scale, 0.0f);
    const Float turned = fma(cosine, c, -sine * s);
    sine = fma(sine, c, cosine * s), cosine = turned;
  }
};

/// The layers for wo, turned and mirrored to above the surface.
TESSERA_INLINE Layers layers_of(const BsdfParams& params, const Turn& turn, Vec3 wo, Mask below,
                                Mask active) {
  const Vec3 upper =
      (params.some_flags & kUsesFurther) != 0 ? turn.into(params.upper_normal) : Vec3{0.0f, 0.0f, 1.0f};
  return {params, wo, upper, below, active};
}

/// `f`, given for radiance, as it is for `transport`.
TESSERA_INLINE Spectrum transported(Transport transport, Mask refracted, const Layers& layers, Spectrum f) {
  if (!layers.disperses) return transported(transport, refracted, layers.eta, f);
  if (transport == Transport::kRadiance) return f;
  return select(refracted, f * layers.etas * layers.etas, f);
}

}  // namespace

BsdfEval GltfBsdf::eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport transport, Mask active) const {
  const Mask below = wo.z < 0.0f;
  const Turn turn(params);
  wo = turn.into(wo), wi = turn.into(wi);
  active &= (wo.z != 0.0f) & (wi.z != 0.0f);
  const Vec3 o = mirror_if(below, wo), i = mirror_if(below, wi);
  const Layers layers = layers_of(params, turn, o, below, active);
  BsdfEval result = eval_above(params, layers, o, i, transport, active).all;
  const Mask refracted = and_not(params.with(kHasInside), same_hemisphere(wo, wi));
  result.f_cos = transported(transport, refracted, layers, result.f_cos);
  return result;
}

BsdfSample GltfBsdf::sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport transport,
                            Mask active) const {
  const Mask below = wo.z < 0.0f, volume = params.with(kHasInside);
  const Turn turn(params);
  wo = mirror_if(below, turn.into(wo));
  active &= wo.z > 0.0f;
  const Layers layers = layers_of(params, turn, wo, below, active);
  active &= ~(layers.inside & (layers.glass <= 0.0f));

  // Base to above, base to below, coat, reflection, and what goes through, in this order.
  const Vec3 wm = layers.facets.sample_visible(wo, u);
  const Float cos_m = dot(wo, wm);
  const Float to_mirror = layers.reflection(layers.reflectance(cos_m));
  const Float after_above = layers.to_above, after_below = after_above + layers.to_below;
  const Float after_coat = after_below + layers.to_coat;
  const Float after_mirror = after_coat + layers.to_facets() * to_mirror;
  const Mask even = u_lobe < after_below, coat = and_not(u_lobe < after_coat, even);
  const Mask through = u_lobe >= after_mirror;
  const Mask to_below = and_not(even, u_lobe < after_above) | through;
  const Mask refracted = through & volume;
  Vec3 wi = reflect(wo, wm, cos_m);
  if (any(active & refracted)) {
    Float eta = layers.eta;
    if (layers.disperses) {
      const Float place = (u_lobe - after_mirror) / max(1.0f - after_mirror, 1e-20f);
      eta = layers.etas.c[0];
      for (int c = 1; c < kSpectrumLanes; ++c)
        eta = select(place * kSpectrumLanes >= static_cast<float>(c), layers.etas.c[c], eta);
    }
    const DielectricFresnel fresnel = fresnel_dielectric(cos_m, eta);
    wi = select(refracted, refract(wo, wm, cos_m, eta, fresnel), wi);
    active &= ~(refracted & (fresnel.eta_cos_t <= 0.0f));
  }
  if (any(active & coat)) {
    const Vec3 o = layers.coat_frame.to_local(wo), normal = coat_facets(params).sample_visible(o, u);
    const Vec3 i = reflect(o, normal, dot(o, normal));
    wi = select(coat, layers.coat_frame.to_shading(i), wi);
    active &= ~(coat & (i.z <= 0.0f));
  }
  if (any(active & even)) wi = select(even, square_to_cosine_hemisphere(u), wi);
  // A sheet lets light through as if it reflected to the other side.
  active &= select(refracted, -wi.z, wi.z) > 0.0f;
  wi.z = select(and_not(to_below, refracted), -wi.z, wi.z);

  const BsdfEval eval = eval_above(params, layers, wo, wi, transport, active).all;
  const Mask valid = active & (eval.pdf > 0.0f);
  return {.wi = turn.back(mirror_if(below, wi)),
          .weight =
              transported(transport, refracted, layers, eval.f_cos * (1.0f / select(valid, eval.pdf, 1.0f))),
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
  const Layers layers = layers_of(params, turn, wo, below, active);
  const LayeredEval eval = eval_above(params, layers, wo, wi, Transport::kRadiance, active);
  return select_or_zero(active, share_of(eval.even, eval.all.f_cos));
}

Spectrum GltfBsdf::albedo(const BsdfParams& params) const { return params.spectra[slot::kReflectance]; }

void GltfBsdf::prepare(const TexturePoint&, Mask lanes, BsdfParams& params) const {
  params.film = {Spectrum(0.0f), Spectrum(0.0f), Float(0.0f)};
  FacetMatter matter(params, Mask::none(), lanes);
  if (matter.filmed) params.film = matter.film_means();
}

const ModelOf<GltfBsdf> gltf(BsdfKind::kGltf);

}  // namespace tessera::render::TESSERA_ISA
