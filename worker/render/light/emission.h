// Light as it leaves its sources: where light tracing begins.
#pragma once

#include "render/light/light.h"

namespace tessera::render::TESSERA_ISA {

/// A ray that leaves light `light` at `time`; `u_place` and `u_direction` are uniform in the unit square.
/// Environments must not have portals.
Emission sample_emission(const LightTable& table, Int light, Float time, Vec2 u_place, Vec2 u_direction,
                         Mask active);

/// The densities with which sample_emission() gives, at `time`, a ray along `direction` from `point`, where
/// the light's geometric normal has this cosine with it (unused by lights without one).
EmissionDensity emission_density(const LightTable& table, Int light, Float time, Vec3 point, Float cosine,
                                 Vec3 direction, Mask active);

/// LightModel::emit of lights at infinity: parallel light through a disk that covers the scene, from where
/// sample() finds it.
Emission emit_from_infinity(const LightModel& model, const LightTable& table, Int light, Float time,
                            Vec2 u_place, Vec2 u_direction, Mask active);

}  // namespace tessera::render::TESSERA_ISA
