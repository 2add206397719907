#include "photometry/glare/contrast.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace tessera::photometry {

namespace {

/// a / b; infinite where only b is 0.
double over(double a, double b, double of_nothing) {
  if (b != 0) return a / b;
  return a == 0 ? of_nothing : std::numeric_limits<double>::infinity();
}

}  // namespace

double weber_contrast(double target, double background) { return over(target - background, background, 0); }

double michelson_contrast(double a, double b) { return over(std::max(a, b) - std::min(a, b), a + b, 0); }

double luminance_ratio(double a, double b) { return over(std::max(a, b), std::min(a, b), 1); }

double uniformity(std::span<const double> values) {
  if (values.empty()) return 0;
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  return sum > 0 ? *std::ranges::min_element(values) * static_cast<double>(values.size()) / sum : 0;
}

double diversity(std::span<const double> values) {
  if (values.empty()) return 0;
  const double most = *std::ranges::max_element(values);
  return most > 0 ? *std::ranges::min_element(values) / most : 0;
}

}  // namespace tessera::photometry
