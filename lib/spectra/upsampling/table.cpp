#include "spectra/upsampling/table.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "spectra/observer/observer.h"

namespace tessera::spectra {
namespace {

double smooth_step(double t) { return t * t * (3 - 2 * t); }

/// The coefficients of colours of one hue are nearly linear in this function of the largest component where
/// that is small, since the sigmoid of -x is near 1 / (4 x^2), and smooth where it is not.
double along(double level) { return -1 / std::sqrt(level); }

/// Where a number lies among ascending ones: between two of them, or beyond the first or the last two.
struct TableCell {
  std::size_t low;
  double weight_of_high;
};

TableCell cell_of(const std::vector<double>& nodes, double number) {
  const auto high = std::upper_bound(nodes.begin() + 1, nodes.end() - 1, number);
  const double low = *(high - 1);
  return {static_cast<std::size_t>(high - nodes.begin()) - 1, (number - low) / (*high - low)};
}

}  // namespace

SigmoidNodes::SigmoidNodes(int resolution) {
  for (int i = 0; i < resolution; ++i) {
    const double t = static_cast<double>(i) / (resolution - 1);
    levels.push_back(smooth_step(smooth_step(t)));
    // Denser near 0, where little of another primary makes much of a difference, and a little near 1.
    ratios.push_back(t * t * (2.5 - 1.5 * t));
  }
  // Black has no coefficients: what is darker than the second level is extrapolated.
  levels[0] = levels[1] / 4;
  for (const double level : levels) along_levels.push_back(along(level));
}

SigmoidCoefficients SigmoidTable::look_up(const Rgb& rgb) const {
  if (rgb.r == rgb.g && rgb.g == rgb.b) return constant_sigmoid(rgb.r);
  std::array<double, 3> v = {rgb.r, rgb.g, rgb.b};
  // Near white, the complement is looked up: the sigmoids of x and -x add up to 1.
  const double sign = *std::min_element(v.begin(), v.end()) > 0.5 ? -1 : 1;
  if (sign < 0) {
    for (double& component : v) component = 1 - component;
  }
  // Its reflectance is 0 to an eye, and coefficients of darker colours outgrow floats.
  constexpr double kDarkest = 1e-12;
  const auto largest = static_cast<std::size_t>(std::max_element(v.begin(), v.end()) - v.begin());
  const TableCell level = cell_of(nodes_.along_levels, along(std::max(v[largest], kDarkest)));
  const TableCell next = cell_of(nodes_.ratios, v[(largest + 1) % 3] / v[largest]);
  const TableCell after_next = cell_of(nodes_.ratios, v[(largest + 2) % 3] / v[largest]);
  const auto weight = [](const TableCell& cell, std::size_t high) {
    return high == 1 ? cell.weight_of_high : 1 - cell.weight_of_high;
  };
  Triple sum = {0, 0, 0};
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const std::size_t up = corner >> 2, right = corner >> 1 & 1, front = corner & 1;
    const std::size_t n = nodes_.ratios.size();
    const std::size_t row =
        ((largest * n + level.low + up) * n + next.low + right) * n + after_next.low + front;
    const double w = weight(level, up) * weight(next, right) * weight(after_next, front);
    for (std::size_t c = 0; c < 3; ++c) sum[c] += w * rows_[4 * row + c];
  }
  return {static_cast<float>(sign * sum[0]), static_cast<float>(sign * sum[1]),
          static_cast<float>(sign * sum[2])};
}

}  // namespace tessera::spectra
