// Media around points that no path has come to.
#pragma once

#include "render/integrator/integrator.h"
#include "render/transport/vertex/path_state.h"

namespace tessera::render::TESSERA_ISA {

/// A straight way from the sensor, whose medium is known, to `point`. Probes are wherever they are: they have
/// that of the scene's camera, whose place is the origin.
WideConnection way_from_sensor(const SceneTables& scene, Vec3 point, Float time, Int slot);

/// Walks all ways of the queue to their ends, through whatever is in between, and sets media[slot] to the
/// medium there. `hits` is room for what they meet.
void find_media(const IntegratorContext& context, ConnectionQueue& ways, HitState& hits,
                Lanes<std::int32_t>& media);

/// The medium that light leaves a light's `point` in along `direction`: `medium`, unless the light is a
/// border.
Int medium_at_light(const SceneTables& scene, Int light, Vec3 point, Vec3 direction, Int medium, Mask active);

/// Lanes whose light has come from infinity through a medium without an end, of which nothing arrives.
Mask is_lost(const SceneTables& scene, Int light, Int medium, Mask active);

}  // namespace tessera::render::TESSERA_ISA
