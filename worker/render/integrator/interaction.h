// From a surface point to a BSDF with its parameters: mixes resolved, textures looked up, normals bent. Shared by all
// integrators.
#pragma once

#include "render/bsdf/bsdf.h"
#include "render/integrator/scene_tables.h"
#include "render/shape/surface.h"

namespace tessera::render::TESSERA_ISA {

/// What scatters light at 16 surface points.
struct Interaction {
  Int kind;  // BsdfKind
  Int flags;  // MaterialFlags
  BsdfParams params;
  Frame frame;  // shading frame, z on the side of the geometric normal
};

/// `u` picks the part of mixed materials.
Interaction interact(const SceneTables& scene, const Surface& surface, Float u, Mask active);

/// f |cos| and pdf in render space, lanes of any kind.
BsdfEval eval_bsdf(const Interaction& at, Vec3 wo, Vec3 wi, Mask active);
BsdfSample sample_bsdf(const Interaction& at, Vec3 wo, Float u_lobe, Vec2 u, Mask active);

/// An estimate of the surface's colour for the albedo AOV.
Spectrum albedo_of(const Interaction& at, Mask active);

}  // namespace tessera::render::TESSERA_ISA
