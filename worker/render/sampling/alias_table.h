// A discrete distribution, sampled in constant time [Walker 1977; Vose 1991].
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace tessera::render {

/// Plain arrays that the kernels gather from; see sampling/discrete.h for the wide side.
struct AliasTable {
  std::vector<float> threshold;     // probability of staying in the bin
  std::vector<std::int32_t> alias;  // the bin to go to otherwise
  std::vector<float> pmf;           // probability of each outcome

  /// Weights need not be normalised; negative or non-finite weights count as zero. All zero: uniform.
  static AliasTable build(std::span<const double> weights);
};

}  // namespace tessera::render
