// Lambertian reflection on the side of wo, Lambertian transmission to the other. pbrt-v4's
// "diffusetransmission".
//
// spectra[0]  reflectance, clamped to [0, 1]
// spectra[1]  transmittance, clamped to [0, 1]
#include "render/bsdf/bsdf.h"

#include "render/core/constants.h"
#include "render/sampling/warp.h"

namespace tessera::render::TESSERA_ISA {

namespace {

class DiffuseTransmissionBsdf final : public Bsdf {
 public:
  DiffuseTransmissionBsdf() : Bsdf(kAllDiffuse) {}
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport transport, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport transport,
                    Mask active) const override;
  Spectrum albedo(const BsdfParams& params) const override;
};

/// Both lobes, and the probability of choosing reflection: by the larger components.
struct Lobes {
  Spectrum reflectance, transmittance;
  Float reflection;
  Mask lit;  // not black altogether

  TESSERA_INLINE explicit Lobes(const BsdfParams& params)
      : reflectance(clamp(params.spectra[slot::kReflectance], 0.0f, 1.0f)),
        transmittance(clamp(params.spectra[slot::kTransmittance], 0.0f, 1.0f)) {
    const Float r = reflectance.max_component(), sum = r + transmittance.max_component();
    lit = sum > 0.0f;
    reflection = r / select(lit, sum, 1.0f);
  }
};

}  // namespace

BsdfEval DiffuseTransmissionBsdf::eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport,
                                       Mask active) const {
  const Lobes lobes(params);
  const Mask reflected = same_hemisphere(wo, wi);
  const Float cosine = select_or_zero(active & lobes.lit & (wo.z != 0.0f), abs_cos_theta(wi) * kInvPi);
  return {select(reflected, lobes.reflectance, lobes.transmittance) * cosine,
          select(reflected, lobes.reflection, 1.0f - lobes.reflection) * cosine};
}

BsdfSample DiffuseTransmissionBsdf::sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport,
                                           Mask active) const {
  const Lobes lobes(params);
  const Mask reflected = u_lobe < lobes.reflection;
  const Float probability = select(reflected, lobes.reflection, 1.0f - lobes.reflection);
  Vec3 wi = square_to_cosine_hemisphere(u);
  const Mask valid = active & lobes.lit & (wi.z > 0.0f) & (wo.z != 0.0f) & (probability > 0.0f);
  const Float pdf = probability * wi.z * kInvPi;
  wi.z = copysign(wi.z, select(reflected, wo.z, -wo.z));
  return {.wi = wi,
          .weight = select(reflected, lobes.reflectance, lobes.transmittance) *
                    (1.0f / select(valid, probability, 1.0f)),
          .pdf = pdf,
          .eta = 1.0f,
          .valid = valid,
          .specular = Mask::none(),
          .transmission = ~reflected};
}

Spectrum DiffuseTransmissionBsdf::albedo(const BsdfParams& params) const {
  return params.spectra[slot::kReflectance] + params.spectra[slot::kTransmittance];
}

const ModelOf<DiffuseTransmissionBsdf> diffuse_transmission(BsdfKind::kDiffuseTransmission);

}  // namespace tessera::render::TESSERA_ISA
