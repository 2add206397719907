// Narrow lobes: which directions are found by sampling the BSDF.
#pragma once

#include "render/core/wide.h"

namespace tessera::render::TESSERA_ISA {

/// Directions that a BSDF gives with more than this density (1/sr) are found by sampling it, all others where
/// photons are: in a narrow lobe lie few of them. Three times what a diffuse surface has at most. Which way
/// light is found is thereby a matter of two directions alone, and each is found in one way.
inline constexpr float kFocused = 1;

/// Lanes in which a direction of this density is left to sampling the BSDF.
TESSERA_INLINE Mask is_focused(Float pdf) { return pdf > kFocused; }

}  // namespace tessera::render::TESSERA_ISA
