#pragma once

#include <cstdint>

namespace tessera::render {

struct ShapeTable;
struct TextureTable;

/// User pointer of the Embree geometry of a mesh with alpha.
struct AlphaGeometry {
  const ShapeTable* shapes = nullptr;
  const TextureTable* textures = nullptr;
  std::int32_t shape = 0;
};

}  // namespace tessera::render
