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
};

struct EmbreeKernel {
  GeometryCallbacks callbacks;
  /// Asks a scene that outlives the query. `first_instance` is the Embree id of instance 0.
  std::unique_ptr<RayQuery> (*make_query)(RTCScene scene, std::int32_t first_instance,
                                          bool single_rays) = nullptr;
};

}  // namespace tessera::render
