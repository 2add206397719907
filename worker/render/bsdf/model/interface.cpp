// No surface at all: what bounds a medium. Light goes straight on. pbrt-v4's "interface", Mitsuba 3's "null".
#include "render/bsdf/bsdf.h"

namespace tessera::render::TESSERA_ISA {

namespace {

class InterfaceBsdf final : public Bsdf {
 public:
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport transport, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport transport,
                    Mask active) const override;
  Passing passing(const BsdfParams& params, Float cosine) const override;
};

}  // namespace

BsdfEval InterfaceBsdf::eval(const BsdfParams&, Vec3, Vec3, Transport, Mask) const {
  return {Spectrum(0.0f), 0.0f};
}

BsdfSample InterfaceBsdf::sample(const BsdfParams&, Vec3 wo, Float, Vec2, Transport, Mask active) const {
  return {.wi = -wo,
          .weight = Spectrum(1.0f),
          .pdf = 1.0f,
          .eta = 1.0f,
          .valid = active,
          .specular = Mask::all(),
          .transmission = Mask::all()};
}

Passing InterfaceBsdf::passing(const BsdfParams&, Float) const { return {Float(1.0f), Spectrum(1.0f)}; }

const ModelOf<InterfaceBsdf> interface(BsdfKind::kInterface);

}  // namespace tessera::render::TESSERA_ISA
