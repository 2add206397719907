// Surfaces that light can pass without being scattered, in volumetric scenes: borders of media, partly opaque
// materials, thin sheets that say so. Passing costs no depth, and light sources are sampled through such
// surfaces, and through clear glass where SceneTables::straight_shadows says so: paths are scattered there.
#pragma once

#include "render/bsdf/bsdf.h"
#include "render/color/spectra.h"
#include "render/integrator/scene_tables.h"
#include "render/shape/surface.h"

namespace tessera::render::TESSERA_ISA {

enum class Passenger : std::uint8_t { kPath, kLight };

/// Lanes whose shape may be passed at all; no need to look closer at the others.
Mask may_pass(const SceneTables& scene, Passenger who, Int shape, Mask active);

/// Through a partly open surface or its model. `d` is the unit direction of travel. Zero probability where
/// the material scatters everything.
Passing passing_at(const SceneTables& scene, Passenger who, const Surface& surface, Vec3 d,
                   const Spectra& spectra, Mask active);

/// Lanes whose material, seen along `d`, is clear glass.
Mask clear_glass_at(const SceneTables& scene, const Surface& surface, Vec3 d, Mask active);

/// Opacity of material `material`, textures looked up.
Float opacity_of(const SceneTables& scene, Int material, const Surface& surface, Mask active);

/// The medium that a ray along `d` is in once it has left the surface, `medium` being the one that it came
/// from.
Int medium_behind(const ShapeTable& shapes, const Surface& surface, Vec3 d, Int medium, Mask active);

}  // namespace tessera::render::TESSERA_ISA
