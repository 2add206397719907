// How many samples a block of pixels needs for a given error [docs/decisions/0013-adaptive.md].
#pragma once

#include <cstdint>

#include "wire/limits.h"

namespace tessera::render {

struct NoiseTarget {
  double noise = 0;           // relative error of a pixel that is wanted; 0: every pixel takes all samples
  std::uint32_t samples = 0;  // a pixel, at most
};

/// Samples of each half that are taken anyway.
inline constexpr std::uint32_t kPilotSamples = wire::kMinAdaptiveSamples / 2;

/// Number of samples that the half takes that did not see the pilot, from kPilotSamples to half of
/// target.samples. `pilot_error`: the squared relative error of a pixel's mean over a pilot, averaged over
/// the block.
std::uint32_t samples_for(const NoiseTarget& target, double pilot_error);

}  // namespace tessera::render
