// A sheet of dielectric without thickness: all orders of reflection between its two sides, no refraction.
// pbrt-v4's "thindielectric", Mitsuba 3's "thindielectric".
//
// spectra[0, 1]  with kTinted: factors of reflected and of transmitted light
// scalars[2]     eta: index of the sheet over the index around it
#include "render/bsdf/bsdf.h"

#include "render/bsdf/fresnel.h"
#include "render/bsdf/tint.h"

namespace tessera::render::TESSERA_ISA {

namespace {

class ThinDielectricBsdf final : public Bsdf {
 public:
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport transport, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport transport,
                    Mask active) const override;
  Passing passing(const BsdfParams& params, Float cosine) const override;
};

/// The reflectance of one of the two boundaries.
TESSERA_INLINE Float reflectance_once(const BsdfParams& params, Float cosine) {
  return fresnel_dielectric(cosine, params.scalars[slot::kEta]).reflectance;
}

}  // namespace

BsdfEval ThinDielectricBsdf::eval(const BsdfParams&, Vec3, Vec3, Transport, Mask) const {
  return {Spectrum(0.0f), 0.0f};
}

BsdfSample ThinDielectricBsdf::sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2, Transport,
                                      Mask active) const {
  // R + T R T + T R^3 T + ... = R + T^2 R / (1 - R^2) = 2 R / (1 + R)
  const Float once = reflectance_once(params, abs_cos_theta(wo));
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

Passing ThinDielectricBsdf::passing(const BsdfParams& params, Float cosine) const {
  const Float once = reflectance_once(params, cosine);
  return {(1.0f - once) / (1.0f + once), tinted(params, Mask::none(), Spectrum(1.0f))};
}

const ModelOf<ThinDielectricBsdf> thin_dielectric(BsdfKind::kThinDielectric);

}  // namespace tessera::render::TESSERA_ISA
