#include "render/bsdf/thin_dielectric.h"

#include "render/bsdf/fresnel.h"
#include "render/bsdf/tint.h"

namespace tessera::render::TESSERA_ISA {

BsdfEval ThinDielectricBsdf::eval(const BsdfParams&, Vec3, Vec3, Mask) const {
  return {Spectrum(0.0f), 0.0f};
}

BsdfSample ThinDielectricBsdf::sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2,
                                      Mask active) const {
  const Float once = fresnel_dielectric(abs_cos_theta(wo), params.scalars[2]).reflectance;
  // R + T R T + T R^3 T + ... = R + T^2 R / (1 - R^2) = 2 R / (1 + R)
  const Float reflectance = 2.0f * once / (1.0f + once);
  const Mask reflected = u_lobe < reflectance;
  return {.wi = {-wo.x, -wo.y, select(reflected, wo.z, -wo.z)},
          .weight = tinted(params, reflected, Spectrum(1.0f)),
          .pdf = select(reflected, reflectance, 1.0f - reflectance),
          .eta = 1.0f,
          .valid = active & (wo.z != 0.0f),
          .specular = Mask::all(),
          .transmission = ~reflected};
}

}  // namespace tessera::render::TESSERA_ISA
