#include "render/bsdf/diffuse.h"

#include "render/core/constants.h"
#include "render/sampling/warp.h"

namespace tessera::render::TESSERA_ISA {

BsdfEval DiffuseBsdf::eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const {
  const Float pdf = select_or_zero(active & same_hemisphere(wo, wi), abs_cos_theta(wi) * kInvPi);
  return {clamp(params.spectra[0], 0.0f, 1.0f) * pdf, pdf};
}

BsdfSample DiffuseBsdf::sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Mask active) const {
  Vec3 wi = square_to_cosine_hemisphere(u);
  const Mask valid = active & (wi.z > 0.0f) & (wo.z != 0.0f);
  const Float pdf = wi.z * kInvPi;
  wi.z = copysign(wi.z, wo.z);
  return {.wi = wi,
          .weight = clamp(params.spectra[0], 0.0f, 1.0f),
          .pdf = pdf,
          .eta = 1.0f,
          .valid = valid,
          .specular = Mask::none(),
          .transmission = Mask::none()};
}

}  // namespace tessera::render::TESSERA_ISA
