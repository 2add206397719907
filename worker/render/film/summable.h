// Which samples a pixel can take, wide.
#pragma once

#include "render/core/wide.h"

namespace tessera::render::TESSERA_ISA {

/// Largest magnitude of a sample. 2^24 of them (wire::kMaxSamplesPerPixel) with filter weights up to 4 have a
/// sum, and a sum of squares, that a float holds: (4e15)^2 * 2^24 = 2.7e38. What is brighter counts as not
/// finite.
inline constexpr float kLargestSample = 1e15f;

/// False for what is not a number, too.
TESSERA_INLINE Mask is_summable(Float x) { return abs(x) <= kLargestSample; }

}  // namespace tessera::render::TESSERA_ISA
