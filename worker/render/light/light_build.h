// Filling a LightTable.
#pragma once

#include <span>

#include "render/light/light_table.h"

namespace tessera::render {

/// Appends a light for every primitive of `shape` (which stands in the world, not in an object) and sets the shape's
/// first_light. `texture` as in LightRecord. Spheres that are cut or not evenly scaled get radius 0, which has them
/// sampled by area.
void append_area_lights(ShapeTable& shapes, std::int32_t shape, std::span<const float, 3> radiance, bool two_sided,
                        std::int32_t texture, std::vector<LightRecord>& lights);

/// Emitted power in watts, mean of R, G and B; of lights at infinity what falls on a disk of the scene's radius.
double light_power(const LightTable& table, const LightRecord& light);

/// How lights are picked: by power, evenly among emitters (an emitting shape counts as one), a quarter by power and the
/// rest evenly, or not at all.
enum class LightSelection { kMixed, kPower, kUniform, kNone };

/// A distribution over table.lights.
AliasTable selection_of_lights(const LightTable& table, LightSelection kind);

}  // namespace tessera::render
