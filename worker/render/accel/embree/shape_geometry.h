#pragma once

#include <cstdint>

namespace tessera::render {

struct ShapeTable;
struct TextureTable;

/// User pointer of the Embree geometry of an analytic shape.
struct ShapeGeometry {
  const ShapeTable* table = nullptr;
  const TextureTable* textures = nullptr;  // used for alpha
  std::int32_t shape = 0;
};

}  // namespace tessera::render
