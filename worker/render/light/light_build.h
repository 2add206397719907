// Filling a LightTable.
#pragma once

#include <cmath>
#include <span>

#include "render/light/light_source.h"
#include "render/light/light_table.h"

namespace tessera::render {

/// Appends the lights of `shape` (which stands in the world, not in an object), as the model for its kind
/// makes them, and sets the shape's first_light; nothing where there is no such model. Two triangles in a row
/// that make a rectangle, without a texture, get two records of one light. `texture` as in LightRecord.
/// Spheres that are cut or not evenly scaled get radius 0, which has them sampled by area.
/// `interpolated_pick` above 0 makes triangles kInterpolated whose vertex normals are not their own.
void append_area_lights(ShapeTable& shapes, std::int32_t shape, std::span<const float, 3> radiance,
                        bool two_sided, std::int32_t texture, LightTable& table, float interpolated_pick = 0);

/// How lights are picked: by power, evenly among emitters (an emitting shape counts as one), three quarters
/// by power and the rest evenly; by LightTable::tree, or by the tree where there are several lights and else
/// mixed; or not at all.
enum class LightSelection { kAuto, kTree, kMixed, kPower, kUniform, kNone };

/// Power that light sampling is there to find: none of lights that another stands for, of compensated
/// environments the part above their mean.
inline double sampled_power(const LightTable& table, const LightRecord& light) {
  if (light.same_as >= 0) return 0;
  const double share = light.environment >= 0
                           ? table.environments[static_cast<std::size_t>(light.environment)].sampled_share
                           : 1;
  const double power = share * table.sources(light.kind).power(table, light);
  return std::isfinite(power) && power > 0 ? power : 0;
}

/// A distribution over table.lights that does not look at the receiver (kAuto, kTree: mixed); empty but for
/// zeros in pmf where nothing is to be sampled.
AliasTable selection_of_lights(const LightTable& table, LightSelection kind);

}  // namespace tessera::render
