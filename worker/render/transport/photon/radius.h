// The radius of the first radiance estimates.
#pragma once

#include "render/accel/ray_query.h"
#include "render/integrator/scene_tables.h"

namespace tessera::render::TESSERA_ISA {

/// The radius of the first pass where nobody says one: some footprints of pixels, as the median of what a
/// grid of rays through the film sees; where none sees anything, a hundredth of the scene's radius.
float radius_by_footprint(const SceneTables& scene, const RayQuery& rays);

}  // namespace tessera::render::TESSERA_ISA
