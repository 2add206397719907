// Whether neighbouring pixels that share light have less noise for their time in a picture
// [docs/decisions/0062-path-sharing.md].
#pragma once

#include "render/integrator/integrator.h"

namespace tessera::render {

/// Noise (relMSE) and number of rays of pixels that share, over those of pixels alone, in a pilot.
struct SharingPilot {
  double noise = 1, rays = 1;
  double error = 0;  // standard error of the logarithm of `noise`

  /// Returns the efficiency (1 / (relMSE x CPU time)) with sharing over that without.
  double gain() const;
  /// Whether that is a gain, and not by chance.
  bool pays() const;
};

/// Renders blocks all over the film twice, with the same paths: alone, and shared by `group`. Few samples are
/// enough, because the noise of both is correlated. The result depends on the scene and its view, and not on
/// the seed, crops, ranges or the number of samples.
SharingPilot make_sharing_pilot(const Algorithm& algorithm, const SceneTables& scene, const RayQuery& rays,
                                const Prepared* prepared, bool scatters, PixelGroup group);

}  // namespace tessera::render
