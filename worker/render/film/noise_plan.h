// How many samples each block of pixels takes, by what a pilot saw [docs/decisions/0060-noise-phase.md].
#pragma once

#include "render/film/noise_pilot.h"
#include "render/film/noise_target.h"
#include "render/film/pixel_filter.h"
#include "render/film/sample_counts.h"

namespace tessera::render {

/// Counts with which the root of the picture's relMSE is about target.noise, from the pilot's error and for
/// the least cost; all the same unless different ones promise to gain something. The pilot has blocks.
/// `noise_share`: variance of a pixel over that of a sample within it, where each takes one.
SampleCounts plan_samples(const NoiseTarget& target, const Pilot& pilot, double noise_share = 1);

/// That share where samples go into all pixels whose filters reach them: the integral of the filter's square.
double scattered_noise_share(const PixelFilterRecord& filter);

/// The number of samples that a sequence is best cut at, at or next to `samples`: a power of two, or half way
/// to the next.
std::uint32_t good_count(double samples);

}  // namespace tessera::render
