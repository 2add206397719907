// Which tests rays and triangles are met by.
#pragma once

#include <string>
#include <vector>

#include "render/accel/intersection_probe.h"
#include "render/accel/ray_query.h"
#include "render/integrator/scene_tables.h"
#include "render/scene/view/settings.h"

namespace tessera::render {

/// Whether triangles are to be met by robust tests: as the job says, or as a probe of the shapes does, which
/// warns of what it found. `names`: the shapes' places in the scene.
bool wants_robust_intersection(const IntersectionProbe& probe, const std::vector<std::string>& names,
                               v1::Intersection wanted, std::vector<std::string>& warnings);

/// Whether what the probe expects fast tests to let through would show: light that is behind surfaces, for
/// which `rays`, by fast tests, are asked (scene/shape/blocked_light.h). Warns where it does.
bool leaks_would_show(const IntersectionProbe& probe, const SceneArrays& arrays, const RayQuery& rays,
                      const std::vector<std::string>& names, std::vector<std::string>& warnings);

}  // namespace tessera::render
