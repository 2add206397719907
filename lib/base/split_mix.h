// A mixing of 64 bits.
#pragma once

#include <cstdint>

namespace tessera::base {

/// The step of SplitMix64's state: odd, so that the states are all 2^64 numbers.
inline constexpr std::uint64_t kSplitMixStep = 0x9e3779b97f4a7c15;

/// The number that SplitMix64 makes in state `x` [Steele, Lea & Flood 2014, Fast Splittable Pseudorandom
/// Number Generators]: a bijection in which every bit of the result depends on all of `x`.
constexpr std::uint64_t split_mix(std::uint64_t x) {
  x += kSplitMixStep;
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9;
  x = (x ^ x >> 27) * 0x94d049bb133111eb;
  return x ^ x >> 31;
}

}  // namespace tessera::base
