// Russian roulette: which paths go on, without bias [Arvo & Kirk 1990].
#pragma once

#include "render/color/spectrum.h"

namespace tessera::render::TESSERA_ISA {

/// Paths end at random only once their throughput is below the inverse of this. Measured:
/// docs/decisions/0006-media-and-passing.md.
inline constexpr float kRouletteCaution = 2;

/// Paths from the eye end at random only after this many further events. Measured:
/// docs/decisions/0006-media-and-passing.md.
inline constexpr int kRouletteStart = 2;

/// The lanes that go on, with more throughput. `scale` makes beta what the path can still bring, about 1 at
/// its start; `most` is the largest probability of going on.
TESSERA_INLINE Mask survive_roulette(Spectrum& beta, Float scale, Float u, float most = 1) {
  const Float survival = clamp((beta * scale).max_component() * kRouletteCaution, 0.05f, most);
  beta *= 1.0f / survival;
  return u < survival;
}

}  // namespace tessera::render::TESSERA_ISA
