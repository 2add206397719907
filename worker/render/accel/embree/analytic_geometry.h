// Analytic shapes as Embree geometry: its callbacks, between its packets and wide values.
#pragma once

#include <cstdint>

#include "render/accel/embree/embree.h"

namespace tessera::render {
struct ShapeTable;
}

namespace tessera::render::TESSERA_ISA {

unsigned count_primitives(const ShapeTable& table, std::int32_t shape);

// The geometry's user pointer is its ShapeGeometry.
void bound_primitive(const RTCBoundsFunctionArguments* args);
void intersect_primitive(const RTCIntersectFunctionNArguments* args);
void occluded_primitive(const RTCOccludedFunctionNArguments* args);

}  // namespace tessera::render::TESSERA_ISA
