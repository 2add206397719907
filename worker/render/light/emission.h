// Light as it leaves its sources: where light tracing begins.
#pragma once

#include "render/light/light.h"

namespace tessera::render::TESSERA_ISA {

/// A ray that carries light.
struct Emission {
  Vec3 origin;     // on the emitter, or outside of the scene
  Vec3 offset;     // by which the ray starts off a surface, along its normal
  Vec3 direction;  // unit
  Spectrum flux;  // that the ray stands for: emitted radiance (or intensity) times cosine over the density of
                  // the ray
  Mask valid;
};

/// A ray from light `light`; `u_place` and `u_direction` are uniform in the unit square. Environments must
/// not have portals.
Emission sample_emission(const LightTable& table, Int light, Vec2 u_place, Vec2 u_direction, Mask active);

}  // namespace tessera::render::TESSERA_ISA
