// How rays go down from an object into those that it holds.
#pragma once

#include "render/accel/embree/inner_geometry.h"

namespace tessera::render::TESSERA_ISA {

// The geometry's user pointer is its InnerGeometry, the context a PlaceContext.
void intersect_inner(const RTCIntersectFunctionNArguments* args);
void occluded_inner(const RTCOccludedFunctionNArguments* args);

}  // namespace tessera::render::TESSERA_ISA
