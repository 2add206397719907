// A dielectric coat over a conductor: pbrt-v4's "coatedconductor". Seen from below it is the same again.
//
// There is no closed form for what goes back and forth between two rough boundaries: eval() and the weight of
// sample() are estimates from random walks, unbiased, as in [Guo et al. 2018; Pharr et al. 2023, sec. 14.3].
// The walks take their numbers from hashes of the directions, so that equal arguments give equal results.
// `pdf` is not the density that the walks have but a smooth function like it, the same in eval() and
// sample(): good for weighing against light sampling, which needs no more, but not for dividing by.
//
// spectra[0, 1]   eta and k of the conductor, relative to the outside
// scalars[0, 1]   GGX alpha of the coat along x and y
// scalars[2]      eta: index of the coat over the index outside
// extended[0, 1]  GGX alpha of the conductor along x and y
// extended[2]     optical thickness of the coat along the normal, all of it absorption
#include "render/bsdf/bsdf.h"

#include "render/bsdf/fresnel.h"
#include "render/bsdf/microfacet.h"
#include "render/sampling/hash.h"

namespace tessera::render::TESSERA_ISA {

namespace {

class CoatedConductorBsdf final : public Bsdf {
 public:
  CoatedConductorBsdf() : Bsdf(kReflectsOnly | kEstimatedDensity) {}
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport transport, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport transport,
                    Mask active) const override;
  Float least_alpha(const BsdfParams& params) const override;
  Spectrum albedo(const BsdfParams& params) const override;
  void prepare(const TexturePoint& at, Mask lanes, BsdfParams& params) const override;
};

/// Visits of the base after which a walk is given up: less than 1e-3 of what is left is lost for the roughest
/// coats.
constexpr int kMostVisits = 24;

/// Random numbers of a walk.
class Stream {
 public:
  TESSERA_INLINE Stream(Vec3 a, Float b, Float c)
      : state_(hash(hash(hash(bit_cast<std::uint32_t>(a.x), bit_cast<std::uint32_t>(a.y)),
                         bit_cast<std::uint32_t>(a.z)),
                    hash(bit_cast<std::uint32_t>(b), bit_cast<std::uint32_t>(c)))) {}

  TESSERA_INLINE Float next() {
    state_ = state_ + 0x9e3779b9u;
    return to_unit_float(hash(state_));
  }
  TESSERA_INLINE Vec2 next_2d() {
    const Float x = next();
    return {x, next()};
  }

 private:
  UInt state_;
};

/// The two boundaries with models of their own. Both are seen from between them: the coat from below, the
/// base from above.
class Layers {
 public:
  Float eta;
  Mask smooth_coat, smooth_base;

  Layers(const BsdfParams& params, Mask active)
      : eta(params.scalars[slot::kEta]),
        smooth_coat(is_smooth_dielectric(params, slot::kAlphaX, slot::kEta)),
        thickness_(params.extended[slot::kThickness]) {
    for (BsdfParams* const layer : {&coat_params_, &base_params_}) {
      layer->flags = layer->variants = Int(0);
      layer->some_flags = layer->some_variants = 0;
    }
    for (int i = 0; i < kMaterialScalars; ++i) coat_params_.scalars[i] = params.scalars[i];
    for (int i = 0; i < 2; ++i) base_params_.scalars[i] = params.extended[slot::kBaseAlphaX + i];
    for (int i = 0; i < 2; ++i) base_params_.spectra[i] = params.spectra[i] * (1.0f / eta);
    smooth_base = is_smooth(base_params_, slot::kAlphaX);
  }

  TESSERA_INLINE BsdfSample sample_coat(Vec3 wo, Float u_lobe, Vec2 u, Mask active) const {
    return bsdf_model(BsdfKind::kDielectric)->sample(coat_params_, wo, u_lobe, u, kAny, active);
  }
  TESSERA_INLINE BsdfEval eval_coat(Vec3 wo, Vec3 wi, Mask active) const {
    return bsdf_model(BsdfKind::kDielectric)->eval(coat_params_, wo, wi, kAny, active);
  }
  TESSERA_INLINE BsdfSample sample_base(Vec3 wo, Vec2 u, Mask active) const {
    return bsdf_model(BsdfKind::kConductor)->sample(base_params_, wo, Float(0.0f), u, kAny, active);
  }
  TESSERA_INLINE BsdfEval eval_base(Vec3 wo, Vec3 wi, Mask active) const {
    return bsdf_model(BsdfKind::kConductor)->eval(base_params_, wo, wi, kAny, active);
  }
  /// Transmittance of the layer between them, along w.
  TESSERA_INLINE Float transmittance(Vec3 w) const { return exp(-thickness_ / max(abs(w.z), 1e-6f)); }

  /// A smooth stand-in for the density of sample(), for directions above the surface.
  Float density(Vec3 wo, Vec3 wi) const {
    constexpr float kBroad = 0.1f;  // for what comes back late
    const Float fresnel = fresnel_dielectric(wo.z, eta).reflectance;
    const Float off_coat =
        select_or_zero(~smooth_coat, eval_reflection(ggx_of(coat_alpha(0), coat_alpha(1)), wo, wi).pdf);
    // The base's tilts count eta times as much outside, and so do the coat's for the part by which refraction
    // follows them, twice.
    const Float twice = sqr(eta - 1.0f) * 0.5f;
    const auto combined = [&](int i) {
      return min(sqrt(sqr(eta * base_params_.scalars[i]) + twice * sqr(coat_alpha(i))), 1.0f);
    };
    const Float off_base = eval_reflection(ggx_of(combined(0), combined(1)), wo, wi).pdf;
    return kBroad * kInvPi * wi.z + (1.0f - kBroad) * lerp(fresnel, off_base, off_coat);
  }

 private:
  // Light comes out of the coat on the side where it went in, which makes both the same.
  static constexpr Transport kAny = Transport::kRadiance;

  TESSERA_INLINE Float coat_alpha(int i) const {
    return select_or_zero(~smooth_coat, coat_params_.scalars[i]);
  }

  BsdfParams coat_params_, base_params_;
  Float thickness_;
};

TESSERA_INLINE Float power_heuristic(Float pdf, Float other) {
  const Float a = sqr(min(pdf, 1e15f)), b = sqr(min(other, 1e15f));
  return a / max(a + b, 1e-30f);
}

/// Part of the light from wi that reaches wo by way of the base: f |cos theta_i|.
Spectrum light_off_base(const Layers& layers, Vec3 wo, Vec3 wi, Mask active) {
  Stream numbers(wo, wi.x + 2.0f * wi.y, wi.z);
  // Smooth coats are passed by both for certain, with the transmittance as a factor; rough ones by chance.
  const auto enter = [&](Vec3 w, Float& factor) {
    const Float u = select(layers.smooth_coat, Float(kOneMinusEpsilon), numbers.next());
    const BsdfSample s = layers.sample_coat(w, u, numbers.next_2d(), active);
    factor = select(layers.smooth_coat, 1.0f - fresnel_dielectric(w.z, layers.eta).reflectance, 1.0f);
    return s;
  };
  Float enters, lit;
  const BsdfSample path = enter(wo, enters), light = enter(wi, lit);
  Mask alive = active & path.valid & path.transmission;
  const Mask shone = light.valid & light.transmission;
  Vec3 down = path.wi;
  Spectrum beta = path.weight * (enters * layers.transmittance(down));
  // By reciprocity the coat scatters light from wi to -light.wi as it would the other way, but for eta^2.
  const Vec3 up = -light.wi;
  const Spectrum incoming =
      light.weight * (lit * sqr(layers.eta) * wi.z / max(up.z, 1e-20f) * layers.transmittance(up));

  Spectrum sum(0.0f);
  for (int visit = 0; visit < kMostVisits && any(alive); ++visit) {
    // Light that was brought in by sampling the coat from wi.
    const Mask meets = and_not(alive & shone, layers.smooth_base);
    if (any(meets)) {
      const BsdfEval base = layers.eval_base(-down, up, meets);
      const Float weight = select(layers.smooth_coat, 1.0f, power_heuristic(light.pdf, base.pdf));
      sum += select_or_zero(meets, beta * base.f_cos * incoming * weight);
    }
    // Up to the coat, which may scatter light from wi this way.
    const BsdfSample base = layers.sample_base(-down, numbers.next_2d(), alive);
    alive &= base.valid;
    beta *= base.weight;
    beta *= layers.transmittance(base.wi);
    const Mask leaves = and_not(alive, layers.smooth_coat);
    if (any(leaves)) {
      const BsdfEval coat = layers.eval_coat(-base.wi, wi, leaves);
      const Float other = layers.eval_coat(wi, -base.wi, leaves).pdf;
      const Float weight = select(layers.smooth_base, 1.0f, power_heuristic(base.pdf, other));
      sum += select_or_zero(leaves, beta * coat.f_cos * weight);
    }
    // And back to the base, or out.
    const Float u_lobe = numbers.next();
    const BsdfSample coat = layers.sample_coat(-base.wi, u_lobe, numbers.next_2d(), alive);
    alive = and_not(alive & coat.valid, coat.transmission);
    down = coat.wi;
    beta *= coat.weight;
    beta *= layers.transmittance(down);
  }
  return sum;
}

}  // namespace

BsdfEval CoatedConductorBsdf::eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport, Mask active) const {
  Mask lit = active & same_hemisphere(wo, wi);
  const Layers layers(params, lit);
  lit = and_not(lit, layers.smooth_coat & layers.smooth_base);
  if (none(lit)) return {Spectrum(0.0f), 0.0f};
  const Mask below = wo.z < 0.0f;
  wo = mirror_if(below, wo);
  wi = mirror_if(below, wi);
  const Spectrum f_cos = layers.eval_coat(wo, wi, lit).f_cos + light_off_base(layers, wo, wi, lit);
  return {select_or_zero(lit, f_cos), select_or_zero(lit, layers.density(wo, wi))};
}

BsdfSample CoatedConductorBsdf::sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport,
                                       Mask active) const {
  const Layers layers(params, active);
  const Mask below = wo.z < 0.0f;
  wo = mirror_if(below, wo);
  Stream numbers(wo, u_lobe, u.x + 2.0f * u.y);

  const BsdfSample entry = layers.sample_coat(wo, u_lobe, u, active);
  Vec3 wi = entry.wi, down = entry.wi;
  Spectrum weight = entry.weight, beta = entry.weight * layers.transmittance(down);
  Mask out = active & entry.valid & ~entry.transmission, alive = active & entry.valid & entry.transmission;
  Mask specular = layers.smooth_coat;
  for (int visit = 0; visit < kMostVisits && any(alive); ++visit) {
    const BsdfSample base = layers.sample_base(-down, numbers.next_2d(), alive);
    alive &= base.valid;
    beta *= base.weight;
    beta *= layers.transmittance(base.wi);
    specular = and_not(specular, and_not(alive, layers.smooth_base));
    const Float u_again = numbers.next();
    const BsdfSample coat = layers.sample_coat(-base.wi, u_again, numbers.next_2d(), alive);
    beta *= coat.weight;
    const Mask leaves = alive & coat.valid & coat.transmission;
    wi = select(leaves, coat.wi, wi);
    weight = select(leaves, beta, weight);
    out |= leaves;
    alive = and_not(alive & coat.valid, coat.transmission);
    down = coat.wi;
    beta *= layers.transmittance(down);
  }
  out &= (wo.z > 0.0f) & (wi.z > 0.0f);
  return {.wi = mirror_if(below, wi),
          .weight = weight,
          .pdf = select(specular, Float(1.0f), layers.density(wo, wi)),
          .eta = 1.0f,
          .valid = out,
          .specular = specular,
          .transmission = Mask::none()};
}

Float CoatedConductorBsdf::least_alpha(const BsdfParams& params) const {
  const Float coat = min(params.scalars[slot::kAlphaX], params.scalars[slot::kAlphaY]);
  return min(coat, min(params.extended[slot::kBaseAlphaX], params.extended[slot::kBaseAlphaY]));
}

Spectrum CoatedConductorBsdf::albedo(const BsdfParams& params) const {
  return normal_reflectance(params.spectra[slot::kConductorEta], params.spectra[slot::kConductorK]);
}

void CoatedConductorBsdf::prepare(const TexturePoint&, Mask lanes, BsdfParams& params) const {
  conductor_of_reflectance(lanes, params.spectra[slot::kConductorEta], params.spectra[slot::kConductorK]);
}

const ModelOf<CoatedConductorBsdf> coated_conductor(BsdfKind::kCoatedConductor);

}  // namespace tessera::render::TESSERA_ISA
