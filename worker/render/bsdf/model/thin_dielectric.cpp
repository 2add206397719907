// A sheet of dielectric without thickness: all orders of reflection between its two sides, no refraction.
// pbrt-v4's "thindielectric", Mitsuba 3's "thindielectric".
//
// spectra[0, 1]  with kTinted: factors of reflected and of transmitted light
// scalars[2]     eta: index of the sheet over the index around it
#include "render/bsdf/bsdf.h"

#include "render/bsdf/dispersed.h"
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
  const auto whole = [](Float once) { return 2.0f * once / (1.0f + once); };
  const Float cosine = abs_cos_theta(wo);
  Float reflectance = whole(reflectance_once(params, cosine));
  Spectrum each(reflectance);
  if (some_disperse(params)) {
    each = reflectances(params, cosine, Mask::none());
    for (Float& lane : each.c) lane = whole(lane);
    reflectance = each.mean();
  }
  const Mask reflected = u_lobe < reflectance;
  const Float pdf = select(reflected, reflectance, 1.0f - reflectance);
  Spectrum weight(1.0f);
  if (some_disperse(params))
    weight = select(reflected, each, Spectrum(1.0f) - each) * (1.0f / max(pdf, 1e-30f));
  return {.wi = {-wo.x, -wo.y, select(reflected, wo.z, -wo.z)},
          .weight = tinted(params, reflected, weight),
          .pdf = pdf,
          .eta = 1.0f,
          .valid = active & (wo.z != 0.0f),
          .specular = Mask::all(),
          .transmission = ~reflected};
}

Passing ThinDielectricBsdf::passing(const BsdfParams& params, Float cosine) const {
  const auto through = [](Float once) { return (1.0f - once) / (1.0f + once); };
  const Spectrum tint = tinted(params, Mask::none(), Spectrum(1.0f));
  if (some_disperse(params)) {
    Spectrum part = reflectances(params, cosine, Mask::none());
    for (Float& lane : part.c) lane = through(lane);
    return passing_of(part, tint);
  }
  return {through(reflectance_once(params, cosine)), tint};
}

const ModelOf<ThinDielectricBsdf> thin_dielectric(BsdfKind::kThinDielectric);

}  // namespace tessera::render::TESSERA_ISA
