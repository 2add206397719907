#include "render/accel/stoppable_query.h"

#include <algorithm>

#include "render/core/stopped.h"

namespace tessera::render {

namespace {

constexpr int kRaysAtATime = 64;

/// The arrays from ray `first` on, a multiple of 16; arrays that are not there stay so.
template <class T>
T* from(T* array, int first) {
  return array == nullptr ? nullptr : array + first;
}

RayArrays from(const RayArrays& rays, int first) {
  return {from(rays.ox, first), from(rays.oy, first), from(rays.oz, first),  from(rays.dx, first),
          from(rays.dy, first), from(rays.dz, first), from(rays.time, first)};
}

HitArrays from(const HitArrays& hits, int first) {
  return {from(hits.t, first),
          from(hits.u, first),
          from(hits.v, first),
          from(hits.primitive, first),
          from(hits.shape, first),
          from(hits.instance, first),
          from(hits.visited_nodes, first),
          from(hits.visited_primitives, first),
          from(hits.upper, first)};
}

}  // namespace

void StoppableQuery::nearest(const RayArrays& rays, int n, bool coherent, const HitArrays& hits) const {
  for (int first = 0; first < n; first += kRaysAtATime) {
    throw_if_stopped(stop_);
    query_.nearest(from(rays, first), std::min(n - first, kRaysAtATime), coherent, from(hits, first));
  }
}

void StoppableQuery::occluded(const RayArrays& rays, int n, float* distance_in_blocked_out) const {
  for (int first = 0; first < n; first += shadow_rays_) {
    throw_if_stopped(stop_);
    query_.occluded(from(rays, first), std::min(n - first, shadow_rays_), distance_in_blocked_out + first);
  }
}

}  // namespace tessera::render
