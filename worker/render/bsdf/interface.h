// No surface at all: what bounds a medium. Light goes straight on. pbrt-v4's "interface", Mitsuba 3's "null".
#pragma once

#include "render/bsdf/bsdf.h"

namespace tessera::render::TESSERA_ISA {

class InterfaceBsdf final : public Bsdf {
 public:
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Mask active) const override;
};

}  // namespace tessera::render::TESSERA_ISA
