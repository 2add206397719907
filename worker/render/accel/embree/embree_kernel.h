// The part of Embree's room that is compiled once an ISA; kernels hand it on.
#pragma once

#include <cstdint>
#include <memory>

#include "render/accel/embree/embree.h"
#include "render/accel/ray_query.h"

namespace tessera::render {

struct ShapeTable;

struct GeometryCallbacks {
  unsigned (*count_primitives)(const ShapeTable& table, std::int32_t shape) = nullptr;
  RTCBoundsFunction bound = nullptr;
  RTCIntersectFunctionN intersect = nullptr;
  RTCOccludedFunctionN occluded = nullptr;
  RTCFilterFunctionN filter_alpha = nullptr;
  // Callbacks of the geometry of an object's instances of others (inner_geometry.h).
  RTCIntersectFunctionN intersect_inner = nullptr;
  RTCOccludedFunctionN occluded_inner = nullptr;
};

struct EmbreeKernel {
  GeometryCallbacks callbacks;
  /// Asks a scene of these shapes, which outlive the query.
  std::unique_ptr<RayQuery> (*make_query)(RTCScene scene, const ShapeTable& shapes,
                                          bool single_rays) = nullptr;
};

}  // namespace tessera::render
