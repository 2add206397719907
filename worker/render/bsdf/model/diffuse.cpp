// Lambertian reflection, on whichever side wo is [Lambert 1760]. pbrt-v4's and Mitsuba 3's "diffuse".
//
// spectra[0]  reflectance, clamped to [0, 1]
#include "render/bsdf/bsdf.h"

#include "render/bsdf/lambertian.h"
#include "render/core/constants.h"
#include "render/sampling/warp.h"

namespace tessera::render::TESSERA_ISA {

namespace {

class DiffuseBsdf final : public Bsdf {
 public:
  DiffuseBsdf() : Bsdf(kReflectsOnly | kLambertian | kAllDiffuse) {}
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport transport, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport transport,
                    Mask active) const override;
  Spectrum albedo(const BsdfParams& params) const override;
};

}  // namespace

BsdfEval DiffuseBsdf::eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport, Mask active) const {
  return eval_lambertian(params.spectra[slot::kReflectance], wo.z, wi.z, active);
}

BsdfSample DiffuseBsdf::sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport,
                               Mask active) const {
  Vec3 wi = square_to_cosine_hemisphere(u);
  const Mask valid = active & (wi.z > 0.0f) & (wo.z != 0.0f);
  const Float pdf = wi.z * kInvPi;
  wi.z = copysign(wi.z, wo.z);
  return {.wi = wi,
          .weight = clamp(params.spectra[slot::kReflectance], 0.0f, 1.0f),
          .pdf = pdf,
          .eta = 1.0f,
          .valid = valid,
          .specular = Mask::none(),
          .transmission = Mask::none()};
}

Spectrum DiffuseBsdf::albedo(const BsdfParams& params) const { return params.spectra[slot::kReflectance]; }

const ModelOf<DiffuseBsdf> diffuse(BsdfKind::kDiffuse);

}  // namespace tessera::render::TESSERA_ISA
