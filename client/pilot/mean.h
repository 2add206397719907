// Means of pictures' figures.
#pragma once

#include <span>

namespace tessera::client {

/// An estimate with the variance that it has itself, and the degrees of freedom of that.
struct Mean {
  double value = 0, variance = 0, dof = 1;
};

/// The mean of two numbers or more.
inline Mean mean_of(std::span<const double> values) {
  const double n = static_cast<double>(values.size());
  double mean = 0, squares = 0;
  for (const double value : values) mean += value / n;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return {mean, squares / (n - 1) / n, n - 1};
}

}  // namespace tessera::client
