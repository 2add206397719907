// A dielectric coat, smooth or rough, over a Lambertian base: pbrt-v4's "coateddiffuse". Seen from below it
// is the same again.
//
// The closed form of the random walk between the two: a Lambertian base forgets where light came from, so
// only energies matter, and the orders of interreflection are a geometric series:
//
//   f(wo, wi) = f_coat(wo, wi) + T(wo) T(wi) / (pi eta^2) rho / (1 - rho R_int)
//
// T(w) is the part of light along w that the coat lets through to the base, R_int the part of diffuse light
// from the base that it sends back; by reciprocity T(wo) / eta^2 of the base's diffuse radiance leaves along
// wo. Smooth coats have T = 1 - Fresnel; for rough ones T and R_int are tabulated for isotropic roughness
// [coat_table.h].
//
// For the energies of an anisotropic coat, and only for them, an isotropic roughness stands in: the root mean
// square of both, turning into the roughness along the light's plane towards grazing directions. That keeps
// within a few percent of the walk, and is exact where both are equal. There is no medium in between: the
// albedo of one is not looked at. The coat's thickness absorbs, as in pbrt-v4; for rough coats as if light
// crossed them as it does smooth ones.
//
// spectra[0]     rho: reflectance of the base, clamped to [0, 1]
// scalars[0, 1]  GGX alpha of the coat along x and y; smooth where both are below kSmoothAlpha
// scalars[2]     eta: index of the coat over the index outside
// coat_table     from append_coat_table(eta, thickness, ...)
#include "render/bsdf/bsdf.h"

#include "render/bsdf/coat_over_diffuse.h"
#include "render/bsdf/tables/coat_table.h"

namespace tessera::render::TESSERA_ISA {

namespace {

class CoatedDiffuseBsdf final : public Bsdf {
 public:
  CoatedDiffuseBsdf() : Bsdf(kReflectsOnly | kSomeDiffuse) {}
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport transport, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport transport,
                    Mask active) const override;
  Float diffuse_share(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const override;
  Float least_alpha(const BsdfParams& params) const override;
  Spectrum albedo(const BsdfParams& params) const override;
};

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
      : eta(params.scalars[slot::kEta]),
        smooth(is_smooth_dielectric(params, slot::kAlphaX, slot::kEta)),
        rough_(and_not(active, smooth)),
        any_rough_(any(rough_)),
        tables_(params.coat_tables),
        offset_(params.coat_table),
        thickness_(gather(params.coat_tables + kCoatThickness, params.coat_table, active)),
        absorbs_(any(active & (thickness_ > 0.0f))) {
    if (!any_rough_) {
      internal = gather(tables_ + kCoatInternal, offset_, active);
      return;
    }
    alpha2_x_ = select_or_zero(rough_, sqr(params.scalars[slot::kAlphaX]));
    alpha2_y_ = select_or_zero(rough_, sqr(params.scalars[slot::kAlphaY]));
    const TablePosition row(sqrt(0.5f * (alpha2_x_ + alpha2_y_)), kCoatAlphas);
    const Int entry = offset_ + row.index;
    internal = lerp(row.t, gather(tables_ + kCoatInternal, entry, active),
                    gather(tables_ + kCoatInternal + 1, entry, active));
  }

  TESSERA_INLINE bool any_rough() const { return any_rough_; }
  TESSERA_INLINE Float one_minus_colour(Float rho) const { return 1.0f - rho * internal; }
  static TESSERA_INLINE Spectrum tinted(const BsdfParams&, Spectrum light) { return light; }

  TESSERA_INLINE Float reflectance(Vec3 w) const {
    const Float analytic = fresnel_dielectric(w.z, eta).reflectance;
    if (!any_rough_) return analytic;
    // Only to choose a lobe by: what the coat absorbs counts as reflected.
    return select(smooth, analytic, 1.0f - transmittance(w));
  }

  /// T(w)
  TESSERA_INLINE Float transmittance(Vec3 w) const {
    const DielectricFresnel boundary = fresnel_dielectric(w.z, eta);
    Float analytic = 1.0f - boundary.reflectance;
    // eta_cos_t over eta is the cosine within the coat.
    if (absorbs_) analytic = analytic * exp(-min(thickness_ * eta / max(boundary.eta_cos_t, 1e-20f), 80.0f));
    if (!any_rough_) return analytic;
    // The mean square of both roughnesses for light along the normal, that along the light's plane for
    // grazing light.
    const Float alpha2 =
        alpha2_x_ * sqr(w.x) + alpha2_y_ * sqr(w.y) + 0.5f * (alpha2_x_ + alpha2_y_) * sqr(w.z);
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
  Float thickness_;
  bool absorbs_;
  Float alpha2_x_, alpha2_y_;
};

}  // namespace

BsdfEval CoatedDiffuseBsdf::eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport, Mask active) const {
  return eval_coat_over_diffuse<Coat>(params, wo, wi, active);
}

BsdfSample CoatedDiffuseBsdf::sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport,
                                     Mask active) const {
  return sample_coat_over_diffuse<Coat>(params, wo, u_lobe, u, active);
}

Float CoatedDiffuseBsdf::diffuse_share(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const {
  return share_below_coat<Coat>(params, wo, wi, active);
}

Float CoatedDiffuseBsdf::least_alpha(const BsdfParams& params) const {
  return min(params.scalars[slot::kAlphaX], params.scalars[slot::kAlphaY]);
}

Spectrum CoatedDiffuseBsdf::albedo(const BsdfParams& params) const {
  return params.spectra[slot::kReflectance];
}

const ModelOf<CoatedDiffuseBsdf> coated_diffuse(BsdfKind::kCoatedDiffuse);

}  // namespace tessera::render::TESSERA_ISA
