#pragma once

#include "render/light/light_table.h"

namespace tessera::render {

/// The tree over all lights of the table that have any power to sample. Empty when there are none.
LightTree build_light_tree(const LightTable& table);

/// From this many bounded lights on the tree brings more than it costs [docs/decisions/0012-lights.md].
inline constexpr int kFewestLightsOfATree = 2;

/// Lights that the tree would hold.
int count_bounded_lights(const LightTable& table);

}  // namespace tessera::render
