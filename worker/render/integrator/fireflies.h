// Samples that stand out, counted as they go to the film and left as they are: clamping would darken the
// image.
#pragma once

#include "render/color/spectrum.h"
#include "render/film/tile_request.h"

namespace tessera::render::TESSERA_ISA {

/// A sample is a firefly when it is so many times as bright as the mean of its batch, which it is part of:
/// that of up to 1024 samples of neighbouring pixels.
inline constexpr float kFireflyRatio = 100;

/// Sum over all lanes.
inline double sum_of(Float a) {
  alignas(64) float lanes[kWidth];
  a.store(lanes);
  double sum = 0;
  for (const float lane : lanes) sum += static_cast<double>(lane);
  return sum;
}

/// `planes`: R, G and B of `samples` samples, with a stride of `stride`; each plane may be read up to a
/// multiple of kWidth.
inline void count_fireflies(const float* planes, std::size_t stride, int samples, RenderStats& stats) {
  const auto brightness = [&](int i) {
    const Float red = Float::load_unaligned(planes + i), green = Float::load_unaligned(planes + stride + i),
                blue = Float::load_unaligned(planes + 2 * stride + i);
    // Filters with negative lobes weigh some samples negatively.
    const Float y = abs(luminance(red, green, blue));
    return select_or_zero(Mask::first(samples - i), y);
  };
  Float sum(0.0f), brightest(0.0f);
  for (int i = 0; i < samples; i += kWidth) {
    const Float y = brightness(i);
    sum += y;
    brightest = max(brightest, y);
  }
  const double light = sum_of(sum);
  stats.light += light;
  const auto least = static_cast<float>(kFireflyRatio * light / samples);
  if (!(reduce_max(brightest) > least)) return;
  for (int i = 0; i < samples; i += kWidth) {
    const Float y = brightness(i);
    const Mask firefly = y > least;
    stats.fireflies += static_cast<std::uint64_t>(count(firefly));
    stats.firefly_light += sum_of(select_or_zero(firefly, y));
  }
}

}  // namespace tessera::render::TESSERA_ISA
