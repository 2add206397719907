// The two halves of a pixel's samples that the AOV `halves` tells apart.
#pragma once

#include <bit>
#include <cstdint>

namespace tessera::wire {

/// Whether a sample belongs to the first half. Of each range [2^k, 2^(k + 1)), the lower part does: a half
/// consists of aligned runs of the sequence, which are evenly spread by themselves, and which half a sample
/// is in does not depend on how many there will be.
constexpr bool in_first_half(std::uint32_t sample) {
  return sample < 2 ? sample == 0 : (sample & std::bit_floor(sample) >> 1) == 0;
}

/// Number of those among the first `samples` samples; a half of them where that is a power of two from 2 on.
constexpr std::uint32_t first_half_of(std::uint32_t samples) {
  if (samples < 2) return samples;
  const std::uint32_t whole = std::bit_floor(samples), rest = samples - whole;
  return whole / 2 + (rest < whole / 2 ? rest : whole / 2);
}

}  // namespace tessera::wire
