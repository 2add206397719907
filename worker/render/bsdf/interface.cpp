#include "render/bsdf/interface.h"

namespace tessera::render::TESSERA_ISA {

BsdfEval InterfaceBsdf::eval(const BsdfParams&, Vec3, Vec3, Mask) const { return {Spectrum(0.0f), 0.0f}; }

BsdfSample InterfaceBsdf::sample(const BsdfParams&, Vec3 wo, Float, Vec2, Mask active) const {
  return {.wi = -wo,
          .weight = Spectrum(1.0f),
          .pdf = 1.0f,
          .eta = 1.0f,
          .valid = active,
          .specular = Mask::all(),
          .transmission = Mask::all()};
}

}  // namespace tessera::render::TESSERA_ISA
