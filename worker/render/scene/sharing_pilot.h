// Whether neighbouring pixels that share light have less noise for their time in a picture, and how long the
// paths are worth following whose light they share [docs/decisions/0062-path-sharing.md].
#pragma once

#include "render/integrator/integrator.h"

namespace tessera::render {

/// Noise (relMSE) and number of rays of pixels that share, over those of pixels alone, in a pilot.
struct SharingPilot {
  double noise = 1, rays = 1;
  double noise_of_blocks = 1;  // noise of means over blocks of kBlock x kBlock pixels
  double alone = 0;            // relMSE of pixels alone, a sample
  double error = 0;            // standard error of the logarithm of the geometric mean of both noises

  /// Side of the areas, in pixels, that a look from afar, a filter or a denoiser sees as one.
  static constexpr int kBlock = 8;

  /// Returns the efficiency (1 / (relMSE x CPU time)) with sharing over that without: the geometric mean of
  /// those of pixels and of blocks.
  double gain() const;
  /// Whether that is a gain, and not by chance.
  bool pays() const;
  /// Whether the gain is above that of `other` by two standard errors. The larger of two groups has to beat
  /// the smaller one, whose noise is less common to neighbours: pilots think too well of large groups
  /// [docs/decisions/0062-path-sharing.md].
  bool beats(const SharingPilot& other) const;
  /// Returns SceneTables::shared_caution. The best probability with which a path goes on is its throughput
  /// times the root of a quotient: the second moment of what is to come over the variance of the picture,
  /// each divided by its costs [Rath et al. 2022]. What is to come is taken to be as uneven as a sample of a
  /// pixel alone, and its share of the costs to be that of any scene.
  float caution() const;
};

/// Returns how many of the other pixels of a pixel's group are in a block with it, on the average over places
/// of the block.
double others_in_block(const PixelGroup& group);

/// Renders blocks all over the film twice, with the same paths: alone, and shared by `group`. Few samples are
/// enough, because the noise of both is correlated. The result depends on the scene and its view, and not on
/// the seed, crops, ranges or the number of samples.
SharingPilot make_sharing_pilot(const Algorithm& algorithm, const SceneTables& scene, const RayQuery& rays,
                                const Prepared* prepared, bool scatters, PixelGroup group);

}  // namespace tessera::render
