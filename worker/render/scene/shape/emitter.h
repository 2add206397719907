// Shapes that emit light.
#pragma once

#include <cstdint>
#include <string>

#include "tessera/v1/scene.pb.h"

namespace tessera::render {

/// A shape of the world with an area light.
struct Emitter {
  std::int32_t shape = 0;  // index in ShapeTable::shapes
  const v1::AreaLight* light = nullptr;
  std::string where;  // place in the scene, for messages
};

}  // namespace tessera::render
