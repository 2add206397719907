#include "photometry/sky/sky_pattern.h"

#include <vector>

namespace tessera::photometry {
namespace {

constexpr double kLowestCosine = 0.01;

struct Node {
  double x, weight;  // within 0 and 1
};

/// Nodes of Gauss and Legendre: roots of the Legendre polynomial by Newton's method.
std::vector<Node> gauss_nodes(int points) {
  std::vector<Node> nodes;
  for (int i = 0; i < points; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (points + 0.5)), slope = 1;
    for (int step = 0; step < 8; ++step) {
      double p = 1, previous = 0;
      for (int n = 1; n <= points; ++n) {
        const double next = ((2 * n - 1) * x * p - (n - 1) * previous) / n;
        previous = p, p = next;
      }
      slope = points * (x * p - previous) / (x * x - 1);
      x -= p / slope;
    }
    nodes.push_back({(1 + x) / 2, 1 / ((1 - x * x) * slope * slope)});
  }
  return nodes;
}

}  // namespace

double relative_luminance(const SkyPattern& pattern, const HorizonDirection& w, const HorizonDirection& sun) {
  if (pattern.traditional_overcast) return (1 + 2 * std::max(w.up, 0.0)) / 3;
  const double gradation = 1 + pattern.a * std::exp(pattern.b / std::max(w.up, kLowestCosine));
  double indicatrix = 1;
  if (pattern.has_indicatrix()) {
    const double angle = angle_between(w, sun), cosine = std::cos(angle);
    indicatrix += pattern.c * (std::exp(pattern.d * angle) - pattern.k) + pattern.e * cosine * cosine;
  }
  return std::max(gradation, 0.0) * std::max(indicatrix, 0.0);
}

double horizontal_integral(const SkyPattern& pattern, const HorizonDirection& sun, int points) {
  const std::vector<Node> nodes = gauss_nodes(points);
  constexpr double kRightAngle = std::numbers::pi / 2;
  const double zenith_of_sun = std::acos(std::clamp(sun.up, -1.0, 1.0));
  const double border = pattern.has_indicatrix() ? std::min(zenith_of_sun, kRightAngle) : kRightAngle;
  // The sky is symmetric about the plane through zenith and sun: half of it will do, from the sun's azimuth
  // on.
  const double sun_azimuth = std::atan2(sun.east, sun.north);
  const auto panel = [&](double low, double high) {
    double sum = 0;
    for (const Node& row : nodes) {
      const double zenith = low + (high - low) * row.x;
      const double sine = std::sin(zenith), cosine = std::cos(zenith);
      double mean = 0;
      for (const Node& column : nodes) {
        const double azimuth = sun_azimuth + std::numbers::pi * column.x;
        const HorizonDirection w{sine * std::sin(azimuth), sine * std::cos(azimuth), cosine};
        mean += column.weight * relative_luminance(pattern, w, sun);
      }
      sum += row.weight * mean * cosine * sine;
    }
    return 2 * std::numbers::pi * (high - low) * sum;
  };
  return panel(0, border) + panel(border, kRightAngle);
}

}  // namespace tessera::photometry
