// Ratios of luminances.
#pragma once

#include <span>

namespace tessera::photometry {

/// (L - background) / background [Weber]: of a small target; negative for a darker one. Infinite before
/// black.
double weber_contrast(double target, double background);

/// (most - least) / (most + least) [Michelson], 0 to 1: of two areas alike in size. 0 where both are black.
double michelson_contrast(double a, double b);

/// The larger over the smaller of two luminances, 1 at least. Infinite beside black, 1 where both are black.
double luminance_ratio(double a, double b);

/// Least over mean, and least over largest, of the illuminances of a grid [EN12464]. 0 for none.
double uniformity(std::span<const double> values);
double diversity(std::span<const double> values);

}  // namespace tessera::photometry
