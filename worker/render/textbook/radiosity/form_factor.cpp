#include "render/textbook/radiosity/form_factor.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tessera::render::TESSERA_ISA::radiosity {

namespace {

/// Height of `p` above the plane through `x`, or 0 where it is seen from there under less than 1e-6: corners
/// are floats, and surfaces that continue each other would see each other by their roundings.
double height_above(const Vec& x, const Vec& normal, const Vec& p) {
  constexpr double kLeastSine = 1e-6;
  const double height = dot(p - x, normal);
  return std::abs(height) > kLeastSine * length(p - x) ? height : 0;
}

}  // namespace

Vec Polygon::point(double u, double v) const {
  // A fan of one or two triangles: the one that u falls into, by area.
  int first = 1;
  if (size == 4) {
    const double a = length(cross(corner[1] - corner[0], corner[2] - corner[0])),
                 b = length(cross(corner[2] - corner[0], corner[3] - corner[0]));
    const double share = a + b > 0 ? a / (a + b) : 1;
    if (u < share) {
      u /= share;
    } else {
      first = 2;
      u = (u - share) / (1 - share);
    }
  }
  const double root = std::sqrt(u);
  return corner[0] * (1 - root) + corner[first] * (root * (1 - v)) + corner[first + 1] * (root * v);
}

Polygon above_horizon(const Vec& x, const Vec& normal, const Vec (&triangle)[3]) {
  double height[3];
  for (int i = 0; i < 3; ++i) height[i] = height_above(x, normal, triangle[i]);
  Polygon above;
  for (int i = 0; i < 3; ++i) {
    const int next = (i + 1) % 3;
    if (height[i] > 0) above.corner[above.size++] = triangle[i];
    if ((height[i] > 0) == (height[next] > 0)) continue;
    const double t = height[i] / (height[i] - height[next]);
    above.corner[above.size++] = triangle[i] + (triangle[next] - triangle[i]) * t;
  }
  return above;
}

double form_factor(const Vec& x, const Vec& normal, const Polygon& polygon) {
  // The angles under which the edges are seen, each projected along the normal of its plane through x.
  double sum = 0;
  for (int i = 0; i < polygon.size; ++i) {
    const Vec a = polygon.corner[i] - x, b = polygon.corner[(i + 1) % polygon.size] - x;
    const Vec across = cross(a, b);
    const double sine = length(across);
    if (sine > 0) sum += std::atan2(sine, dot(a, b)) * dot(normal, across) / sine;
  }
  return std::abs(sum) / (2 * std::numbers::pi);
}

double View::largest() const { return std::max({factor[0], factor[1], factor[2]}); }

double View::spread() const { return largest() - std::min({factor[0], factor[1], factor[2]}); }

View view(const Patch& receiver, const Patch& source) {
  View result;
  for (int i = 0; i < kPoints; ++i) {
    const Vec x = receiver.point(kPoint[i]);
    if (!(height_above(source.corner[0], source.normal, x) > 0)) continue;
    result.seen[i] = above_horizon(x, receiver.normal, source.corner);
    if (result.seen[i].size > 0) result.factor[i] = form_factor(x, receiver.normal, result.seen[i]);
  }
  return result;
}

}  // namespace tessera::render::TESSERA_ISA::radiosity
