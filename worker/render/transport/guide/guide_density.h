// From counts and sums to a density of directions.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "render/transport/guide/guide_cell.h"

namespace tessera::render::TESSERA_ISA {

/// Samples in a bin, and the sum of their values.
struct GuideTally {
  double value = 0, count = 0;
};

/// The probabilities of kGuideBins bins, in rows: that of a quarter of any square of bins is its share of the
/// square's light, mixed with an even one, which counts as kGuideSmoothing samples. So few samples make few
/// differences, and no bin is left out.
std::vector<double> guide_density(std::span<const GuideTally> bins);

inline constexpr double kGuideSmoothing = 4;

}  // namespace tessera::render::TESSERA_ISA
