// Rays of a unit of work that may be stopped.
#pragma once

#include <stop_token>

#include "render/accel/ray_query.h"

namespace tessera::render {

/// Asks another query, some rays at a time, and throws Stopped once a stop is requested: however slow a
/// structure is, a unit ends within the time of those rays. It outlives neither the query nor the token.
class StoppableQuery final : public RayQuery {
 public:
  /// `shadow_rays`: how many are asked at a time (RayStructure::shadow_rays_at_a_time).
  StoppableQuery(const RayQuery& query, int shadow_rays, const std::stop_token& stop)
      : query_(query), shadow_rays_(shadow_rays), stop_(stop) {}

  void nearest(const RayArrays& rays, int n, bool coherent, const HitArrays& hits) const override;
  void occluded(const RayArrays& rays, int n, float* distance_in_blocked_out) const override;
  RayVisits visits() const override { return query_.visits(); }

 private:
  const RayQuery& query_;
  const int shadow_rays_;
  const std::stop_token& stop_;
};

}  // namespace tessera::render
