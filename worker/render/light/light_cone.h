// Cones of directions in which lights that move, or deform, shine.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "render/light/light_source.h"

namespace tessera::render {

/// Sets the cone about all of `directions`, each with a cone of `angle` about it; all directions where there
/// is no narrow one.
inline void set_cone(const std::vector<vec64::Vec>& directions, double angle, LightBounds& b) {
  constexpr double kSlack = 1e-3;  // maps between two steps turn by a little more or less than rotations do
  vec64::Vec sum = {0, 0, 0};
  for (const vec64::Vec& d : directions) sum = sum + unit(d);
  b.axis = unit(sum);
  double widest = 0;
  for (const vec64::Vec& d : directions)
    widest = std::max(widest, std::acos(std::clamp(dot(b.axis, unit(d)), -1.0, 1.0)));
  // Sums stay within a cone that is narrower than a half-space.
  b.angle = widest < 0.49 * std::numbers::pi ? std::min(widest + angle + kSlack, std::numbers::pi)
                                             : std::numbers::pi;
}

}  // namespace tessera::render
