// Sample sequences. A value is a pure function of (seed, pixel, sample index, dimension), so any machine can
// make any sample of any pixel.
#pragma once

#include "render/core/constants.h"
#include "render/core/vec.h"
#include "render/sampling/hash.h"
#include "render/sampling/sampler_config.h"

namespace tessera::render::TESSERA_ISA {

/// Owen scrambling of the bit-reversed number `x`: every bit is flipped as a hash of the bits below it says
/// [Laine & Karras 2011], constants of [Vegdahl 2021].
TESSERA_INLINE UInt scramble_reversed(UInt x, UInt seed) {
  x = x ^ (x * 0x3d20adeau);
  x = x + seed;
  x = x * (shift_right<16>(seed) | 1u);
  x = x ^ (x * 0x05526c56u);
  return x ^ (x * 0x53a22864u);
}

/// The second Sobol' dimension, bit-reversed: Pascal's triangle mod 2 as a butterfly.
TESSERA_INLINE UInt pascal_reversed(UInt x) {
  x = x ^ shift_right<1>(x & 0xaaaaaaaau);
  x = x ^ shift_right<2>(x & 0xccccccccu);
  x = x ^ shift_right<4>(x & 0xf0f0f0f0u);
  x = x ^ shift_right<8>(x & 0xff00ff00u);
  return x ^ shift_right<16>(x & 0xffff0000u);
}

/// Returns the remainder of a polynomial over GF(2), its coefficients the bits of `p`, by x^4 + x + 1.
TESSERA_INLINE UInt remainder_by_primitive(UInt p) {
  p = (p & 0xffffu) ^ shift_right<16>(p) * 2u;  // x^16 is x
  for (int i = 0; i < 2; ++i) {
    const UInt high = shift_right<8>(p);  // x^8 is x^2 + 1
    p = (p & 0xffu) ^ high ^ (high * 4u);
  }
  for (int i = 0; i < 2; ++i) {
    const UInt high = shift_right<4>(p);  // x^4 is x + 1
    p = (p & 0xfu) ^ high ^ (high * 2u);
  }
  return p;
}

/// The sequences of 16 (pixel, sample) pairs. "sobol" pads the first two Sobol' dimensions: each pair of
/// dimensions is the same (0,2)-sequence, its order shuffled and its values Owen-scrambled by hashes of pixel
/// and dimension [Burley 2020].
///
/// "group sobol" does this for kGroupSize pixels at once, which have one sequence: sample i of a pixel is one
/// of the points 16 i to 16 i + 15, each of them another pixel's. So samples i of all 16 pixels are a
/// (0,4,2)-net, and the first 2^k samples of all a (0,k+4,2)-net. Which of the 16 points a pixel takes is its
/// number in the group plus the remainder of i x^4, i being a polynomial: its own samples are a
/// (0,2)-sequence then as well (checked for the first 2^14), where those that always took the same would lie
/// in a strip.
class Sampler {
 public:
  /// `pixel` is pixel_hash() of the pixel, `reversed_sample` the bit-reversed sample index. For kGroupSobol
  /// `pixel` is group_key().
  TESSERA_INLINE Sampler(SamplerKind kind, UInt pixel, UInt reversed_sample)
      : kind_(kind), pixel_(pixel), reversed_sample_(reversed_sample) {}

  static TESSERA_INLINE UInt pixel_hash(std::uint64_t seed, UInt x, UInt y) {
    return hash(hash(x, UInt(static_cast<std::uint32_t>(seed))),
                hash(y, UInt(static_cast<std::uint32_t>(seed >> 32))));
  }

  /// Key of one of the pixel's sequences, independent of those of other streams; stream 0 is the pixel
  /// itself.
  static TESSERA_INLINE UInt stream_hash(UInt pixel, UInt stream) {
    return pixel ^ hash(stream);  // hash(0) is 0
  }

  /// For kGroupSobol, from the hash of the group's first pixel and the pixel's number in the group.
  static TESSERA_INLINE UInt group_key(UInt hash_of_first, UInt member) {
    return (hash_of_first & ~(kGroupSize - 1)) | member;
  }

  /// Two numbers in [0, 1), jointly stratified over the samples of a pixel.
  TESSERA_INLINE Vec2 get_2d(int pair) const {
    const bool grouped = kind_ == SamplerKind::kGroupSobol;
    const UInt sequence = grouped ? pixel_ & ~(kGroupSize - 1) : pixel_;
    const UInt seed = hash(sequence + static_cast<std::uint32_t>(pair) * 0x9e3779b9u);
    if (kind_ == SamplerKind::kIndependent) {
      const UInt x = hash(reversed_sample_, seed);
      return {to_unit_float(x), to_unit_float(hash(x ^ 0x68bc21ebu))};
    }
    UInt index = reverse_bits(scramble_reversed(reversed_sample_, seed));
    if (grouped) {
      index = index * kGroupSize;
      // The numbers of pixels are shuffled as those of samples are: with the last bit by all others.
      const UInt member = shift_right<28>(
          reverse_bits(scramble_reversed(pixel_ & (kGroupSize - 1), hash(seed ^ 0x9216d5d9u))));
      index = index | (member ^ remainder_by_primitive(index));
    }
    const UInt x = reverse_bits(scramble_reversed(index, hash(seed ^ 0xa511e9b3u)));
    const UInt y = reverse_bits(scramble_reversed(pascal_reversed(index), hash(seed ^ 0x63d83595u)));
    return {to_unit_float(x), to_unit_float(y)};
  }

 private:
  SamplerKind kind_;
  UInt pixel_;
  UInt reversed_sample_;
};

}  // namespace tessera::render::TESSERA_ISA
