#pragma once

#include "render/accel/embree.h"

namespace tessera::render {

/// Compiled once an ISA, so handed to the builder by the kernel.
struct GeometryCallbacks {
  RTCIntersectFunctionN intersect_quadric = nullptr;
  RTCOccludedFunctionN occluded_quadric = nullptr;
  RTCIntersectFunctionN intersect_sdf = nullptr;
  RTCOccludedFunctionN occluded_sdf = nullptr;
  RTCFilterFunctionN filter_alpha = nullptr;
};

}  // namespace tessera::render
