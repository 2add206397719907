// Light behind surfaces, against the light that arrives: what rays would show that slip between triangles.
#pragma once

#include "render/accel/ray_query.h"
#include "render/integrator/scene_tables.h"

namespace tessera::render {

/// Sums over light samples at places before surfaces that are seen from the origin of render space, directly
/// or by way of others: of those that nothing is in the way of, and of the others. Squares tell single bright
/// samples from much light.
struct BlockedLight {
  double arriving = 0, arriving_squares = 0;
  double blocked = 0, blocked_squares = 0;

  /// Shares of the mean and of the samples' variance that light may have which slips through.
  static constexpr double kSafeMean = 1e-3;
  static constexpr double kSafeVariance = 1e-2;

  /// Whether light shows in a picture where a ray slips through what it should meet with the probability
  /// `leak`.
  bool shows(double leak) const {
    return leak * blocked > kSafeMean * arriving || leak * blocked_squares > kSafeVariance * arriving_squares;
  }
};

/// Walks at random from the origin through the scene, and samples a light half-way to each surface that a
/// walk meets. What lets light through is passed. `lights` know the scene's radius. Order of magnitude only:
/// surfaces scatter half of what they get, evenly, and skies shine evenly.
BlockedLight measure_blocked_light(const SceneArrays& arrays, const RayQuery& rays);

}  // namespace tessera::render
