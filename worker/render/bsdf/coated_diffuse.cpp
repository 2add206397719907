#include "render/bsdf/coated_diffuse.h"

#include "render/bsdf/coat_table.h"
#include "render/bsdf/fresnel.h"
#include "render/bsdf/microfacet.h"

namespace tessera::render::TESSERA_ISA {

namespace {

constexpr int kAlpha = 0, kEta = 2;  // slots

/// Places between which a table is interpolated.
struct TablePosition {
  Int index;  // of the lower of two neighbours
  Float t;    // 0 there, 1 at the upper

  /// `x` in [0, 1] along `count` entries that are spaced as the squares.
  TESSERA_INLINE TablePosition(Float x, int count) {
    const Float position = clamp(sqrt(x) * (count - 1.0f), 0.0f, count - 1.0f);
    const Float low = min(floor(position), count - 2.0f);
    index = to_int(low);
    t = position - low;
  }
};

/// Energies of the coat, for directions above the surface.
class Coat {
 public:
  Float eta;
  Mask smooth;
  Float internal;  // R_int

  TESSERA_INLINE Coat(const BsdfParams& params, Mask active)
      : eta(params.scalars[kEta]),
        smooth(is_smooth_dielectric(params, kAlpha, kEta)),
        rough_(and_not(active, smooth)),
        any_rough_(any(rough_)),
        tables_(params.coat_tables),
        offset_(params.coat_table) {
    if (!any_rough_) {
      internal = gather(tables_ + kCoatInternal, offset_, active);
      return;
    }
    alpha2_x_ = select_or_zero(rough_, sqr(params.scalars[kAlpha]));
    alpha2_y_ = select_or_zero(rough_, sqr(params.scalars[kAlpha + 1]));
    const TablePosition row(sqrt(0.5f * (alpha2_x_ + alpha2_y_)), kCoatAlphas);
    const Int entry = offset_ + row.index;
    internal =
        lerp(row.t, gather(tables_ + kCoatInternal, entry, active), gather(tables_ + kCoatInternal + 1, entry, active));
  }

  TESSERA_INLINE bool any_rough() const { return any_rough_; }

  /// T(w)
  TESSERA_INLINE Float transmittance(Vec3 w) const {
    const Float analytic = 1.0f - fresnel_dielectric(w.z, eta).reflectance;
    if (!any_rough_) return analytic;
    // The mean square of both roughnesses for light along the normal, that along the light's plane for grazing light.
    const Float alpha2 = alpha2_x_ * sqr(w.x) + alpha2_y_ * sqr(w.y) + 0.5f * (alpha2_x_ + alpha2_y_) * sqr(w.z);
    const TablePosition row(sqrt(alpha2), kCoatAlphas), column(w.z, kCoatCosines);
    const Int entry = offset_ + row.index * kCoatCosines + column.index;
    const auto along_row = [&](const float* start) {
      return lerp(column.t, gather(start, entry, rough_), gather(start + 1, entry, rough_));
    };
    const float* low = tables_ + kCoatTransmittance;
    return select(smooth, analytic, lerp(row.t, along_row(low), along_row(low + kCoatCosines)));
  }

 private:
  Mask rough_;
  bool any_rough_;
  const float* tables_;
  Int offset_;
  Float alpha2_x_, alpha2_y_;
};

/// What depends on wo only: radiance that leaves along wo per irradiance that enters, and how to choose a lobe.
struct Lobes {
  Float fresnel_o;  // of the smooth coat; only meaningful there
  Spectrum base;    // T(wo) rho / (eta^2 (1 - rho R_int))
  Float coat;       // probability of sampling the coat's lobe

  TESSERA_INLINE Lobes(const BsdfParams& params, const Coat& coat_energy, Vec3 wo) {
    const Float transmitted = coat_energy.transmittance(wo);
    fresnel_o = 1.0f - transmitted;
    const Spectrum rho = clamp(params.spectra[0], 0.0f, 1.0f);
    const Float factor = transmitted / sqr(coat_energy.eta);
    for (int i = 0; i < kSpectrumLanes; ++i) {
      base.c[i] = factor * rho.c[i] / max(1.0f - rho.c[i] * coat_energy.internal, 1e-6f);
    }
    // By energy, as far as it is known without integration: diffuse light leaves a smooth coat as 1 - R_int does.
    const Float base_energy = base.max_component() * sqr(coat_energy.eta) * (1.0f - coat_energy.internal);
    const Float sum = fresnel_o + base_energy;
    coat = fresnel_o / select(sum > 0.0f, sum, 1.0f);
  }
};

/// f cos and pdf of both lobes, delta lobes apart, where `lit`.
TESSERA_INLINE BsdfEval eval_lobes(const BsdfParams& params, const Coat& coat, const Lobes& lobes, Vec3 wo, Vec3 wi,
                                   Mask lit) {
  const Float cosine = select_or_zero(lit, wi.z * kInvPi);
  BsdfEval result{lobes.base * (coat.transmittance(wi) * cosine), (1.0f - lobes.coat) * cosine};
  if (coat.any_rough()) {
    const Mask rough = and_not(lit, coat.smooth);
    const MicrofacetReflection reflection = eval_reflection(ggx_of(params, kAlpha), wo, wi);
    const Float fresnel = fresnel_dielectric(reflection.cos_m, coat.eta).reflectance;
    result.f_cos += Spectrum(select_or_zero(rough, fresnel * reflection.f_cos));
    result.pdf += select_or_zero(rough, lobes.coat * reflection.pdf);
  }
  return result;
}

}  // namespace

BsdfEval CoatedDiffuseBsdf::eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const {
  const Mask lit = active & same_hemisphere(wo, wi);
  if (none(lit)) return {Spectrum(0.0f), 0.0f};
  const Mask below = wo.z < 0.0f;
  wo = mirror_if(below, wo);
  wi = mirror_if(below, wi);
  const Coat coat(params, lit);
  BsdfEval result = eval_lobes(params, coat, Lobes(params, coat, wo), wo, wi, lit);
  result.f_cos = select_or_zero(lit, result.f_cos);
  return result;
}

BsdfSample CoatedDiffuseBsdf::sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Mask active) const {
  const Mask below = wo.z < 0.0f;
  wo = mirror_if(below, wo);
  active &= wo.z > 0.0f;
  const Coat coat(params, active);
  const Lobes lobes(params, coat, wo);

  // A direction from one of the lobes.
  const Mask off_coat = u_lobe < lobes.coat;
  Vec3 wi{-wo.x, -wo.y, wo.z};
  if (any(active & off_coat) && coat.any_rough()) {
    const Vec3 wm = ggx_of(params, kAlpha).sample_visible(wo, u);
    wi = select(coat.smooth, wi, reflect(wo, wm, dot(wo, wm)));
  }
  if (any(and_not(active, off_coat))) wi = select(off_coat, wi, square_to_cosine_hemisphere(u));

  // Its weight over both lobes, unless it came from a mirror.
  const Mask mirror = off_coat & coat.smooth;
  const Mask lit = active & (wi.z > 0.0f);
  BsdfEval eval = eval_lobes(params, coat, lobes, wo, wi, lit);
  eval.f_cos = select(mirror, Spectrum(lobes.fresnel_o), eval.f_cos);
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
