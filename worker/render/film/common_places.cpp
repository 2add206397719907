#include "render/film/common_places.h"

#include "base/split_mix.h"

namespace tessera::render {
namespace {

float to_unit(std::uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24f; }

std::uint32_t van_der_corput(std::uint32_t index) {
  std::uint32_t bits = 0;
  for (std::uint32_t digit = 1u << 31; index != 0; index >>= 1, digit >>= 1) bits ^= index & 1 ? digit : 0;
  return bits;
}
std::uint32_t second_sobol(std::uint32_t index) {
  std::uint32_t bits = 0;
  for (std::uint32_t digit = 1u << 31; index != 0; index >>= 1, digit ^= digit >> 1)
    bits ^= index & 1 ? digit : 0;
  return bits;
}

/// Flips each bit as the bits above it say.
std::uint32_t scramble(std::uint32_t bits, std::uint64_t seed) {
  std::uint32_t flips = 0;
  for (std::uint32_t bit = 0; bit < 32; ++bit) {
    const std::uint64_t above = bit == 0 ? 0 : bits >> (32 - bit);
    // The leading 1 tells prefixes of different lengths apart.
    const std::uint64_t node = base::split_mix(seed ^ (above | std::uint64_t{1} << bit));
    flips |= static_cast<std::uint32_t>(node >> 63) << (31 - bit);
  }
  return bits ^ flips;
}

}  // namespace

Place shifted_place(std::uint64_t seed, std::uint32_t index) {
  const std::uint64_t digits = base::split_mix(seed);
  return {to_unit(van_der_corput(index) ^ static_cast<std::uint32_t>(digits)),
          to_unit(second_sobol(index) ^ static_cast<std::uint32_t>(digits >> 32))};
}

Place scrambled_place(std::uint64_t seed, std::uint32_t index) {
  const std::uint64_t axis = base::split_mix(seed);
  return {to_unit(scramble(van_der_corput(index), axis)),
          to_unit(scramble(second_sobol(index), base::split_mix(axis)))};
}

}  // namespace tessera::render
