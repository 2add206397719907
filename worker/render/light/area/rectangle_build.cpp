#include "render/light/area/rectangle_build.h"

#include <algorithm>
#include <cmath>

namespace tessera::render::TESSERA_ISA {
namespace {

constexpr double kTolerance = 2e-5;  // of the shorter side, and of the right angle

double dot(const double (&a)[3], const double (&b)[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

const float* corner(const LightRecord& triangle, int k) { return triangle.vertices + 3 * (k % 3); }
bool same_point(const float* a, const float* b) { return std::equal(a, a + 3, b); }

/// Whether the corner `k` of one triangle and `opposite` make a rectangle with what they share. Fills its
/// sides, in the order that keeps the front.
bool is_rectangle(const LightRecord& triangle, int k, const float* opposite, double (&x)[3], double (&y)[3]) {
  const float *p = corner(triangle, k), *next = corner(triangle, k + 1), *last = corner(triangle, k + 2);
  double off[3];
  for (int c = 0; c < 3; ++c) {
    x[c] = double{next[c]} - p[c];
    y[c] = double{last[c]} - p[c];
    off[c] = p[c] + x[c] + y[c] - opposite[c];
  }
  const double shorter = std::sqrt(std::min(dot(x, x), dot(y, y)));
  return shorter > 0 && std::sqrt(dot(off, off)) <= kTolerance * shorter &&
         std::abs(dot(x, y)) <= kTolerance * std::sqrt(dot(x, x) * dot(y, y));
}

}  // namespace

bool merge_into_rectangle(LightRecord& first, std::int32_t first_index, LightRecord& second) {
  if (first.kind != LightKind::kTriangle || second.kind != LightKind::kTriangle) return false;
  if (first.texture >= 0 || second.texture >= 0) return false;
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < 3; ++j) {
      // The side that they share runs the other way in the other triangle.
      if (!same_point(corner(first, k + 1), corner(second, j + 2)) ||
          !same_point(corner(first, k + 2), corner(second, j + 1))) {
        continue;
      }
      double x[3], y[3];
      if (!is_rectangle(first, k, corner(second, j), x, y)) return false;
      const double width = std::sqrt(dot(x, x)), height = std::sqrt(dot(y, y));
      LightRecord rectangle = first;
      rectangle.kind = LightKind::kRectangle;
      rectangle.area = static_cast<float>(width * height);
      rectangle.tan_x = static_cast<float>(width);
      rectangle.tan_y = static_cast<float>(height);
      for (int c = 0; c < 3; ++c) {
        rectangle.vertices[c] = corner(first, k)[c];
        rectangle.vertices[3 + c] = static_cast<float>(x[c] / width);
        rectangle.vertices[6 + c] = static_cast<float>(y[c] / height);
        const int d = (c + 1) % 3, e = (c + 2) % 3;
        rectangle.direction[c] = static_cast<float>((x[d] * y[e] - x[e] * y[d]) / (width * height));
      }
      const std::int32_t second_primitive = second.primitive;
      first = second = rectangle;
      second.primitive = second_primitive;
      second.same_as = first_index;
      return true;
    }
  }
  return false;
}

}  // namespace tessera::render::TESSERA_ISA
