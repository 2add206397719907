#include "render/film/noise_target.h"

#include <algorithm>
#include <cmath>

namespace tessera::render {
namespace {

/// Relative standard deviation of single samples at which a block ends with exactly the error asked for: that
/// of the usual pixel, as far as stratification leaves it.
constexpr double kUsualDeviation = 1.0 / 3;

}  // namespace

std::uint32_t samples_for(const NoiseTarget& target, double pilot_error) {
  const std::uint32_t most = std::max(target.samples / 2, kPilotSamples);
  const double deviation = std::sqrt(pilot_error * kPilotSamples) / kUsualDeviation;
  // In proportion to the deviation over the root of the cost: the least work for a mean squared error [Neyman
  // 1934]. Paths that deviate more are longer, too: they cost about the root of it. The same error everywhere
  // (the square of the deviation) would take as many samples as no adaptation at all.
  const double weight = std::sqrt(deviation) * std::sqrt(std::sqrt(deviation));
  const double both = weight * kUsualDeviation * kUsualDeviation / (target.noise * target.noise);
  // Not a number is as bad as infinite.
  if (!(both / 2 < most)) return most;
  // Sequences are best cut at powers of two, and next best half way to the next.
  std::uint32_t count = kPilotSamples;
  while (count < both / 2) count += count & (count - 1) ? count / 3 : count / 2;
  return std::min(count, most);
}

}  // namespace tessera::render
