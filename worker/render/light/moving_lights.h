// Lights that move while the shutter is open, and those that instances place.
#pragma once

#include <cstdint>
#include <vector>

#include "render/core/affine_data.h"
#include "render/light/light_table.h"

namespace tessera::render {

/// The way of a light: steps of maps from its own space to render space, as core/motion.h has them.
struct LightMotion {
  std::int32_t first_step = 0;  // in MovingLights::steps
  std::int32_t segments = 1;
  std::int32_t instance = -1;  // of lights on a shape: its place, in ShapeTable::instances
};

/// Each such light has a record in LightTable::lights, of one of the kinds kMoving..., and under the same
/// number one here, of the kind that it is but for its motion, in its own space.
struct MovingLights {
  /// Lights on shapes have no textures here: those are looked up where the shape is.
  LightTable still;
  std::vector<std::int32_t> motion_of_light;  // in `motions`, for each light; -1: it stands still
  std::vector<LightMotion> motions;
  std::vector<Affine> steps;
  bool moves = false;  // one of them does, and is not only placed by an instance
};

}  // namespace tessera::render
