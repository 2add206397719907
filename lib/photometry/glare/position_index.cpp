#include "photometry/glare/position_index.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tessera::photometry {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kLargest = 16;

/// [Iwata1997]: by the distance from the line of sight, over that of the plane across it in which both are.
double below(const ViewDirection& s) {
  const double ratio = std::min(std::hypot(s.right, s.up) / s.forward, 3.0);
  return 1 + (ratio > 0.6 ? 1.2 : 0.8) * ratio;
}

/// Guth. `off`: degrees from the line of sight; `tilt`: degrees of the plane of both from the vertical.
double above(const ViewDirection& s) {
  const double tilt = std::atan2(std::abs(s.right), s.up) * kDegrees;
  const double off = std::atan2(std::hypot(s.right, s.up), s.forward) * kDegrees;
  return std::exp((35.2 - 0.31889 * tilt - 1.22 * std::exp(-2 * tilt / 9)) * 1e-3 * off +
                  (21 + 0.26667 * tilt - 0.002963 * tilt * tilt) * 1e-5 * off * off);
}

}  // namespace

double position_index(const ViewDirection& source) {
  if (!(source.forward > 0)) return kLargest;
  return std::clamp(source.up < 0 ? below(source) : above(source), 1.0, kLargest);
}

}  // namespace tessera::photometry
