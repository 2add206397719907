// The part of Embree's room that is compiled once an ISA; kernels hand it on.
#pragma once

#include <cstdint>
#include <memory>

#include "render/accel/embree.h"
#include "render/accel/ray_query.h"

namespace tessera::render {

struct GeometryCallbacks {
  RTCIntersectFunctionN intersect_quadric = nullptr;
  RTCOccludedFunctionN occluded_quadric = nullptr;
  RTCIntersectFunctionN intersect_sdf = nullptr;
  RTCOccludedFunctionN occluded_sdf = nullptr;
  RTCFilterFunctionN filter_alpha = nullptr;
};

struct EmbreeKernel {
  GeometryCallbacks callbacks;
  /// Asks a scene that outlives the query. `first_instance` is the Embree id of instance 0.
  std::unique_ptr<RayQuery> (*make_query)(RTCScene scene, std::int32_t first_instance,
                                          bool single_rays) = nullptr;
};

}  // namespace tessera::render
