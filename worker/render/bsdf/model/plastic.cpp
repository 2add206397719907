// A dielectric coat, smooth or rough, over a Lambertian base, as Mitsuba 3's "plastic" and "roughplastic"
// model it [d'Eon & Irving 2011]:
//
//   f(wo, wi) = tint f_coat(wo, wi) + T(wo) T(wi) / (pi eta^2) rho / (1 - R)
//
// or, with kNonlinear, rho / (1 - rho R). T(w) is the part of light along w that the coat lets through and R
// the part of diffuse light from the base that it sends back: Fresnel's for smooth coats, tables for rough
// ones [plastic_table.h]. pbrt-v4's coat, whose energies are exact, is coated_diffuse.h. Seen from below it
// is the same again.
//
// spectra[0]     rho: reflectance of the base
// spectra[1]     tint: factor of the light that the coat reflects
// scalars[0, 1]  alpha of the coat; smooth below kSmoothAlpha
// scalars[2]     eta: index of the coat over the index outside
// coat_table     from append_plastic_table()
#include "render/bsdf/bsdf.h"

#include "render/bsdf/coat_over_diffuse.h"
#include "render/bsdf/tables/plastic_table.h"

namespace tessera::render::TESSERA_ISA {

namespace {

class PlasticBsdf final : public Bsdf {
 public:
  PlasticBsdf() : Bsdf(kReflectsOnly | kSomeDiffuse) {}
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport transport, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport transport,
                    Mask active) const override;
  Float diffuse_share(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const override;
  Float least_alpha(const BsdfParams& params) const override;
  Spectrum albedo(const BsdfParams& params) const override;
};

/// Energies of the coat [coat_over_diffuse.h].
class Coat {
 public:
  Float eta;
  Mask smooth;
  Float internal;  // R

  TESSERA_INLINE Coat(const BsdfParams& params, Mask active)
      : eta(params.scalars[slot::kEta]),
        smooth(is_smooth(params, slot::kAlphaX)),
        internal(gather(params.coat_tables + kPlasticInternal, params.coat_table, active)),
        rough_(and_not(active, smooth)),
        any_rough_(any(rough_)),
        nonlinear_(params.of_variant(kNonlinear)),
        transmittances_(params.coat_tables + kPlasticTransmittance),
        offset_(params.coat_table) {}

  TESSERA_INLINE bool any_rough() const { return any_rough_; }

  TESSERA_INLINE Float transmittance(Vec3 w) const {
    const Float analytic = 1.0f - fresnel_dielectric(w.z, eta).reflectance;
    if (!any_rough_) return analytic;
    const Float position = clamp(w.z, 0.0f, 1.0f) * (kPlasticCosines - 1.0f);
    const Float low = min(floor(position), kPlasticCosines - 2.0f);
    const Int entry = offset_ + to_int(low);
    const Float tabulated = lerp(position - low, gather(transmittances_, entry, rough_),
                                 gather(transmittances_ + 1, entry, rough_));
    return select(smooth, analytic, tabulated);
  }

  TESSERA_INLINE Float reflectance(Vec3 w) const { return 1.0f - transmittance(w); }

  TESSERA_INLINE Float one_minus_colour(Float rho) const {
    return 1.0f - select(nonlinear_, rho, 1.0f) * internal;
  }

  static TESSERA_INLINE Spectrum tinted(const BsdfParams& params, Spectrum light) {
    return light * params.spectra[slot::kCoatTint];
  }

 private:
  Mask rough_;
  bool any_rough_;
  Mask nonlinear_;
  const float* transmittances_;
  Int offset_;
};

}  // namespace

BsdfEval PlasticBsdf::eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport, Mask active) const {
  return eval_coat_over_diffuse<Coat>(params, wo, wi, active);
}

BsdfSample PlasticBsdf::sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport,
                               Mask active) const {
  return sample_coat_over_diffuse<Coat>(params, wo, u_lobe, u, active);
}

Float PlasticBsdf::diffuse_share(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const {
  return share_below_coat<Coat>(params, wo, wi, active);
}

Float PlasticBsdf::least_alpha(const BsdfParams& params) const {
  return min(params.scalars[slot::kAlphaX], params.scalars[slot::kAlphaY]);
}

Spectrum PlasticBsdf::albedo(const BsdfParams& params) const { return params.spectra[slot::kReflectance]; }

const ModelOf<PlasticBsdf> plastic(BsdfKind::kPlastic);

}  // namespace tessera::render::TESSERA_ISA
