// The radii of radiance estimates.
#pragma once

#include <cstdint>

#include "render/accel/ray_query.h"
#include "render/integrator/scene_tables.h"

namespace tessera::render::TESSERA_ISA {

/// The radius of pass `pass`, 0 the first, `first` being the first's: r_i = r_1 i^((alpha - 1) / 2), with
/// alpha = 2/3, so that no pass needs to know of others [Knaus & Zwicker 2011, equation 20, whose product has
/// this asymptote].
float radius_of_pass(float first, std::uint32_t pass);

/// The radius of the first pass where nobody says one: some footprints of pixels, as the median of what a
/// grid of rays through the film sees; where none sees anything, a hundredth of the scene's radius.
float radius_by_footprint(const SceneTables& scene, const RayQuery& rays);

}  // namespace tessera::render::TESSERA_ISA
