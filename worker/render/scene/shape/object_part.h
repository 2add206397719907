// One thing that an object, or the world, places.
#pragma once

#include <cstdint>
#include <vector>

#include "render/scene/placement/motion.h"
#include "render/scene/placement/transform.h"

namespace tessera::render {

struct ObjectPart {
  std::int32_t object = -1;  // index in ShapeTable::objects
  Transform place;           // placement in the holder's space; not read where it moves
  std::vector<Motion> way;   // maps that lead to a part that moves, the outermost first

  bool moves() const { return !way.empty(); }
  /// Time 0 is when the shutter opens, 1 when it closes.
  Transform at(double time) const;
  MotionSteps steps() const { return steps_of_product(way); }
  /// The part where something moves its holder so.
  ObjectPart placed_by(const Motion& motion) const;
};

}  // namespace tessera::render
