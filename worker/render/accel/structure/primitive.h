// The elements of structures: one record for whatever a ray may meet, with all that its test reads.
#pragma once

#include <cstdint>

#include "render/accel/structure/box.h"

namespace tessera::render {

enum class PrimitiveKind : std::int16_t {
  kTriangle,
  kAnalytic,   // a shape of shape/analytic_shape.h
  kInstance,   // an object where an instance places it
  kDeforming,  // a triangle of a mesh that deforms
};

struct Primitive {
  float corners[3][3];     // of a kTriangle; of the others the lower and the upper end of its box, then zeros
  std::int32_t shape = 0;  // index in ShapeTable::shapes; kInstance: -1
  std::int32_t number = 0;  // index among the shape's primitives; kInstance: index in ShapeTable::instances
  PrimitiveKind kind = PrimitiveKind::kTriangle;
  std::int16_t has_alpha = 0;  // some rays pass through it
};
static_assert(sizeof(Primitive) == 48);

inline Box box_of(const Primitive& primitive) {
  Box box;
  const int points = primitive.kind == PrimitiveKind::kTriangle ? 3 : 2;
  for (int i = 0; i < points; ++i) box.add(primitive.corners[i]);
  return box;
}

}  // namespace tessera::render
