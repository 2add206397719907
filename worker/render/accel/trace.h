// Tracing rays that lie in structures of arrays.
#pragma once

#include "render/accel/embree.h"
#include "render/core/wide.h"

namespace tessera::render::TESSERA_ISA {

/// Arrays of at least `n` rays, rounded up to 16; aligned to 64 bytes. Directions have unit length.
struct RayArrays {
  const float *ox, *oy, *oz, *dx, *dy, *dz;
  const float* time = nullptr;  // from 0 (the shutter opens) to 1; null: 0 for all
};

/// `shape` is -1 on a miss, and the rest then undefined. `instance` is -1 outside instances, else its number
/// counted from 0. `t` is infinite on a miss.
struct HitArrays {
  float *t, *u, *v;
  std::int32_t *primitive, *shape, *instance;
};

/// Nearest hits along the rays. `first_instance` is the Embree id of instance 0. Rays that are not finite, or have
/// coordinates beyond 1.8e18, meet nothing.
void trace_nearest(RTCScene scene, const RayArrays& rays, int n, Traversal traversal, std::int32_t first_instance,
                   const HitArrays& hits);

/// Sets blocked[i] to a negative number where something lies within `distance` along the ray, else leaves the distance.
/// Rays that are not finite are blocked.
void trace_shadow(RTCScene scene, const RayArrays& rays, int n, Traversal traversal, float* distance_in_blocked_out);

}  // namespace tessera::render::TESSERA_ISA
