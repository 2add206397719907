// Keys by which a Sampler knows the samples of a film.
#pragma once

#include <algorithm>

#include "render/sampling/sampler.h"

namespace tessera::render::TESSERA_ISA {

struct SampleKey {
  UInt pixel, reversed_sample;  // arguments of Sampler()
};

namespace detail {

/// The lowest 8 bits, each followed by a zero.
TESSERA_INLINE UInt spread_bits(UInt x) {
  x = (x | (x * 16u)) & 0x0f0fu;
  x = (x | (x * 4u)) & 0x3333u;
  return (x | (x * 2u)) & 0x5555u;
}

/// Pixels of a square share a sequence: they follow each other in Z order, each with 2^sample_bits samples,
/// so that neighbours' samples are stratified together, and their errors are blue noise [Ahmed & Wonka 2020].
/// Squares have up to 256 pixels a side, as many as 32 bits of the sequence's index leave room for.
TESSERA_INLINE SampleKey z_order_key(const SamplerConfig& config, UInt x, UInt y, UInt sample) {
  const int side_bits = std::min(8, (32 - config.sample_bits) / 2);
  const std::uint32_t within = (1u << side_bits) - 1;
  const UInt order = spread_bits(x & within) | (spread_bits(y & within) * 2u);
  const UInt square = Sampler::pixel_hash(config.seed, x & ~within, y & ~within);
  return {square, reverse_bits(order * (1u << config.sample_bits) + sample)};
}

}  // namespace detail

namespace detail {

/// The pixels of a square of kGroupSize share a sequence, in which squares within it follow each other.
TESSERA_INLINE UInt square_key(std::uint64_t seed, UInt x, UInt y) {
  static_assert(kGroupSize == 16);
  const UInt member = spread_bits(x & 3u) | (spread_bits(y & 3u) * 2u);
  return Sampler::group_key(Sampler::pixel_hash(seed, x & ~3u, y & ~3u), member);
}

}  // namespace detail

/// The key of a pixel's sample; `sample` is below 2^config.sample_bits where there are any.
TESSERA_INLINE SampleKey sample_key(const SamplerConfig& config, UInt x, UInt y, UInt sample) {
  if (config.kind == SamplerKind::kZSobol) return detail::z_order_key(config, x, y, sample);
  if (config.kind == SamplerKind::kGroupSobol)
    return {detail::square_key(config.seed, x, y), reverse_bits(sample)};
  return {Sampler::pixel_hash(config.seed, x, y), reverse_bits(sample)};
}

}  // namespace tessera::render::TESSERA_ISA
