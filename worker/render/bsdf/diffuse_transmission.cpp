#include "render/bsdf/diffuse_transmission.h"

#include "render/core/constants.h"
#include "render/sampling/warp.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Both lobes, and the probability of choosing reflection: by the larger components.
struct Lobes {
  Spectrum reflectance, transmittance;
  Float reflection;
  Mask lit;  // not black altogether

  TESSERA_INLINE explicit Lobes(const BsdfParams& params)
      : reflectance(clamp(params.spectra[0], 0.0f, 1.0f)),
        transmittance(clamp(params.spectra[1], 0.0f, 1.0f)) {
    const Float r = reflectance.max_component(), sum = r + transmittance.max_component();
    lit = sum > 0.0f;
    reflection = r / select(lit, sum, 1.0f);
  }
};

}  // namespace

BsdfEval DiffuseTransmissionBsdf::eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const {
  const Lobes lobes(params);
  const Mask reflected = same_hemisphere(wo, wi);
  const Float cosine = select_or_zero(active & lobes.lit & (wo.z != 0.0f), abs_cos_theta(wi) * kInvPi);
  return {select(reflected, lobes.reflectance, lobes.transmittance) * cosine,
          select(reflected, lobes.reflection, 1.0f - lobes.reflection) * cosine};
}

BsdfSample DiffuseTransmissionBsdf::sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u,
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

}  // namespace tessera::render::TESSERA_ISA
