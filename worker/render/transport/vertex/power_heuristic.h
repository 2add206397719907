// Weights of samples that several strategies could have taken.
#pragma once

#include "render/core/wide.h"

namespace tessera::render::TESSERA_ISA {

/// Power heuristic with exponent 2 [Veach 1997], for one sample of each strategy.
TESSERA_INLINE Float power_heuristic(Float pdf, Float other) {
  const Float a = sqr(pdf), b = sqr(other);
  // Overflowing squares: the larger density wins outright.
  return select(is_finite(a + b), a / max(a + b, 1e-38f), select(pdf > other, Float(1.0f), Float(0.0f)));
}

}  // namespace tessera::render::TESSERA_ISA
