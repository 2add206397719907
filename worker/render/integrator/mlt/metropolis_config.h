// Settings of Metropolis light transport (tessera.v1.MetropolisSettings), as the kernels read them; without
// any choices, for jobs have them all.
#pragma once

#include <cstdint>

namespace tessera::render {

/// How paths are changed (tessera.v1.MutationKind): in primary sample space, or in path space by one of the
/// strategies there, or by all of them in turn.
enum class MutationKind : std::uint8_t { kPrimary, kPath, kBidirectional, kLens, kCaustic, kMultiChain };

struct MetropolisConfig {
  std::uint32_t mutations = 1;   // of a chain
  std::uint32_t candidates = 1;  // for each chain to begin at
  float large_steps = 0.3f;      // probability
  float step = 1.0f / 32;        // largest change of a number by a small step
  MutationKind kind = MutationKind::kPrimary;
};

}  // namespace tessera::render
