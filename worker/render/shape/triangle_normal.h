#pragma once

#include "render/core/vec.h"

namespace tessera::render::TESSERA_ISA {

/// The power of two that brings sides to size 1, `size` being the largest of their coordinates: products of
/// four lengths of 1e-10 or 1e10 are beyond a float.
TESSERA_INLINE Float scale_of_sides(Float size) {
  constexpr std::uint32_t kExponent = 0x7f800000, kTwiceOne = 0x7f000000;
  return bit_cast<float>(UInt(kTwiceOne) - (bit_cast<std::uint32_t>(size) & kExponent));
}

/// cross(e1, e2) at unit length, `size` being the largest of their coordinates.
TESSERA_INLINE Vec3 triangle_normal(Vec3 e1, Vec3 e2, Float size) {
  const Float scale = scale_of_sides(size);
  return normalize(cross(e1 * scale, e2 * scale));
}

}  // namespace tessera::render::TESSERA_ISA
