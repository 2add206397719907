#pragma once

#include <cstdint>

namespace tessera::render {

struct ShapeTable;

/// User pointer of the Embree geometry of an analytic shape.
struct ShapeGeometry {
  const ShapeTable* table = nullptr;
  std::int32_t shape = 0;
};

}  // namespace tessera::render
