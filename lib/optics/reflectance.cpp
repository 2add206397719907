#include "optics/reflectance.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tessera::optics {

namespace {

double cosine_behind(double before, double behind, double cosine) {
  const double ratio = before / behind;
  return std::sqrt(std::max(1 - ratio * ratio * (1 - cosine * cosine), 0.0));
}

/// Reflectance of a layer whose two sides reflect these amplitudes; `phase` is that of going to and fro in
/// it.
double of_layer(double first, double second, double phase) {
  const double both = first * second, interference = 2 * both * std::cos(phase);
  return (first * first + second * second + interference) / (1 + both * both + interference);
}

}  // namespace

double reflectance(double before, double behind, const std::optional<Coating>& coating, double cosine,
                   double nm) {
  if (before == behind) return 0;
  const double c0 = std::abs(cosine), c2 = cosine_behind(before, behind, c0);
  if (c2 == 0) return 1;
  const auto s_of = [](double n, double c, double n_next, double c_next) {
    return (n * c - n_next * c_next) / (n * c + n_next * c_next);
  };
  const auto p_of = [](double n, double c, double n_next, double c_next) {
    return (n_next * c - n * c_next) / (n_next * c + n * c_next);
  };
  if (!coating) {
    const double s = s_of(before, c0, behind, c2), p = p_of(before, c0, behind, c2);
    return (s * s + p * p) / 2;
  }
  // Beyond the angle at which the layer alone would reflect all, the wave in it dies away: not so in lenses.
  constexpr double kLeastCosine = 1e-3;
  const double n = coating->index, c1 = std::max(cosine_behind(before, n, c0), kLeastCosine);
  const double phase = 4 * std::numbers::pi * n * c1 * coating->thickness_nm / nm;
  const double s = of_layer(s_of(before, c0, n, c1), s_of(n, c1, behind, c2), phase),
               p = of_layer(p_of(before, c0, n, c1), p_of(n, c1, behind, c2), phase);
  return (s + p) / 2;
}

}  // namespace tessera::optics
