// Tracing rays that lie in structures of arrays, by Embree.
#pragma once

#include <memory>

#include "render/accel/embree/embree.h"
#include "render/accel/embree/embree_kernel.h"
#include "render/accel/ray_query.h"
#include "render/core/wide.h"

namespace tessera::render::TESSERA_ISA {

/// Does what RayQuery::nearest does. `first_instance` is the Embree id of instance 0; `nested`: the shapes,
/// where they are of a scene with objects in objects.
void trace_nearest(RTCScene scene, const RayArrays& rays, int n, Traversal traversal,
                   std::int32_t first_instance, const HitArrays& hits, const ShapeTable* nested = nullptr);

/// Does what RayQuery::occluded does.
void trace_shadow(RTCScene scene, const RayArrays& rays, int n, Traversal traversal,
                  float* distance_in_blocked_out);

/// These kernels' callbacks for Embree.
const EmbreeKernel& embree_kernel();

}  // namespace tessera::render::TESSERA_ISA
