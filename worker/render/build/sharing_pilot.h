// Whether neighbouring pixels that share light have less noise for their time in a picture
// [docs/decisions/0062-path-sharing.md].
#pragma once

#include "render/integrator/integrator.h"

namespace tessera::render {

/// What sharing does, as a pilot sees it: how many times the noise (relMSE) and the rays of pixels alone.
struct SharingPilot {
  double noise = 1, rays = 1;

  /// How many times as efficient sharing is: error times CPU time.
  double gain() const;
};

/// Renders blocks all over the film twice, with the same paths, which `group` share in one of them. Few
/// samples tell, as both have the same noise. A function of the scene and its view: of no crop, range or
/// number of samples.
SharingPilot make_sharing_pilot(const Algorithm& algorithm, const SceneTables& scene, const RayQuery& rays,
                                const Prepared* prepared, bool scatters, PixelGroup group);

}  // namespace tessera::render
