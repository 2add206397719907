// Axis-aligned boxes, as builders add them up.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace tessera::render {

/// Empty as it is made: the lower end beyond the upper one.
struct Box {
  static constexpr float kInfinity = std::numeric_limits<float>::infinity();
  float low[3] = {kInfinity, kInfinity, kInfinity};
  float high[3] = {-kInfinity, -kInfinity, -kInfinity};

  bool empty() const { return !(low[0] <= high[0] && low[1] <= high[1] && low[2] <= high[2]); }
  bool finite() const {
    for (int k = 0; k < 3; ++k) {
      if (!std::isfinite(low[k]) || !std::isfinite(high[k])) return false;
    }
    return true;
  }
  void add(const Box& other) {
    for (int k = 0; k < 3; ++k)
      low[k] = std::min(low[k], other.low[k]), high[k] = std::max(high[k], other.high[k]);
  }
  void add(const float* p) {
    for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], p[k]), high[k] = std::max(high[k], p[k]);
  }
  /// Where it and `other` overlap; empty where they do not.
  Box within(const Box& other) const {
    Box both;
    for (int k = 0; k < 3; ++k)
      both.low[k] = std::max(low[k], other.low[k]), both.high[k] = std::min(high[k], other.high[k]);
    return both;
  }
  double extent(int axis) const { return double{high[axis]} - low[axis]; }
  /// Halves are added first, so that two ends of 3e38 have a centre.
  float centre(int axis) const { return 0.5f * low[axis] + 0.5f * high[axis]; }
  /// Half of the surface: what a random line meets is in proportion to it. 0 where it is empty.
  double area() const {
    if (empty()) return 0;
    const double x = extent(0), y = extent(1), z = extent(2);
    return x * y + y * z + z * x;
  }
  int longest_axis() const {
    const int axis = extent(0) >= extent(1) ? 0 : 1;
    return extent(axis) >= extent(2) ? axis : 2;
  }
  float largest_coordinate() const {
    float most = 0;
    for (int k = 0; k < 3; ++k) most = std::max({most, std::abs(low[k]), std::abs(high[k])});
    return most;
  }
};

}  // namespace tessera::render
