// From a triangle on the film to the samples that it covers, row by row, without a rounding: places are whole
// numbers of sub-pixels.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

namespace tessera::render::TESSERA_ISA {

/// Sub-pixels along a side of a pixel.
inline constexpr std::int32_t kSubPixels = 256;
/// Largest coordinate of a corner: twice the product of two fits a double.
inline constexpr std::int32_t kGuard = 1 << 22;

/// Sample (column, row) is at (column, row) * kSubPixels.
struct FilmTriangle {
  std::array<std::int32_t, 3> x, y;
  std::array<float, 3> nearness;
};

/// A row of samples that a triangle covers, both ends included. Nearness is linear along it.
struct Span {
  int row, first, last;
  double nearness_at_0, nearness_per_column;
};

namespace detail {

/// The half-plane of a side: the samples (i, j) for which i * per_column + j * per_row + at_origin >= 0.
struct Side {
  double per_column, per_row, at_origin;
  double inverse;  // 1 / |per_column|, or 0

  Side(double ax, double ay, double bx, double by) {
    const double dx = bx - ax, dy = by - ay;
    per_column = -dy * kSubPixels;
    per_row = dx * kSubPixels;
    at_origin = dy * ax - dx * ay;
    // Top and left sides have the samples upon them; the others leave them to the neighbour [Pineda 1988].
    const bool top_or_left = dy < 0 || (dy == 0 && dx > 0);
    if (!top_or_left) at_origin -= 1;
    inverse = per_column == 0 ? 0 : 1 / std::abs(per_column);
  }

  /// Narrows [first, last] to the samples of a row that are inside.
  void narrow(int row, double& first, double& last) const {
    const double value = per_row * row + at_origin;
    if (per_column == 0) {
      if (value < 0) last = -1;
      return;
    }
    // The value is a whole number below 2^46, and the divisor below 2^31: a quotient that is no whole number
    // is 2^-31 off the next one at least, while roundings here are below 2^-44 for the few columns that
    // matter.
    constexpr double kNothing = 0x1p-33;
    const double crossing = value * inverse;
    if (per_column > 0) {
      first = std::max(first, std::ceil(-crossing - kNothing));
    } else {
      last = std::min(last, std::floor(crossing + kNothing));
    }
  }
};

}  // namespace detail

/// Calls fill(Span) for the rows of a grid of `columns` x `rows` samples that the triangle covers, whichever
/// way round it goes. Of triangles that meet at a side, one covers a sample upon it.
template <class Fill>
void scan_convert(const FilmTriangle& triangle, int columns, int rows, Fill&& fill) {
  std::array<int, 3> order{0, 1, 2};
  const auto& [x, y, nearness] = triangle;
  const auto doubled_area = [&] {
    const auto [a, b, c] = order;
    return double(x[b] - x[a]) * (y[c] - y[a]) - double(x[c] - x[a]) * (y[b] - y[a]);
  };
  if (doubled_area() < 0) std::swap(order[1], order[2]);
  const double area = doubled_area();
  if (area == 0) return;
  const auto [a, b, c] = order;
  const detail::Side sides[] = {{double(x[a]), double(y[a]), double(x[b]), double(y[b])},
                                {double(x[b]), double(y[b]), double(x[c]), double(y[c])},
                                {double(x[c]), double(y[c]), double(x[a]), double(y[a])}};

  const double x1 = x[b] - x[a], y1 = y[b] - y[a], x2 = x[c] - x[a], y2 = y[c] - y[a];
  const double n1 = double(nearness[b]) - nearness[a], n2 = double(nearness[c]) - nearness[a];
  const double per_x = (n1 * y2 - n2 * y1) / area, per_y = (n2 * x1 - n1 * x2) / area;

  // Arithmetic shifts round down.
  const int top = std::max((std::min({y[0], y[1], y[2]}) + kSubPixels - 1) / kSubPixels, 0);
  const int bottom = std::min(std::max({y[0], y[1], y[2]}) >> 8, rows - 1);
  static_assert(kSubPixels == 1 << 8);
  for (int row = top; row <= bottom; ++row) {
    double first = 0, last = columns - 1;
    for (const detail::Side& side : sides) side.narrow(row, first, last);
    if (first > last) continue;
    const double at_0 = nearness[a] + per_y * (double(row) * kSubPixels - y[a]) - per_x * x[a];
    fill(Span{row, static_cast<int>(first), static_cast<int>(last), at_0, per_x * kSubPixels});
  }
}

}  // namespace tessera::render::TESSERA_ISA
