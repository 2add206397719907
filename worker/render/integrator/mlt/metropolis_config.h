// Settings of Metropolis light transport (tessera.v1.MetropolisSettings), as the kernels read them; without
// any choices, for jobs have them all.
#pragma once

#include <cstdint>

namespace tessera::render {

struct MetropolisConfig {
  std::uint32_t mutations = 1;   // of a chain
  std::uint32_t candidates = 1;  // for each chain to begin at
  float large_steps = 0.3f;      // probability
  float step = 1.0f / 32;        // largest change of a number by a small step
};

}  // namespace tessera::render
