#include "spectra/upsampling/table.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "spectra/upsampling/fit.h"

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

SigmoidTable::SigmoidTable(int resolution) : resolution_(static_cast<std::size_t>(resolution)) {
  entries_.resize(3 * resolution_ * resolution_ * resolution_);
  for (std::size_t i = 0; i < resolution_; ++i) {
    const double t = static_cast<double>(i) / (resolution - 1);
    levels_.push_back(smooth_step(smooth_step(t)));
    // Denser near 0, where little of another primary makes much of a difference, and a little near 1.
    ratios_.push_back(t * t * (2.5 - 1.5 * t));
  }
  // Black has no coefficients: what is darker than the second level is extrapolated.
  levels_[0] = levels_[1] / 4;
  for (const double level : levels_) along_levels_.push_back(along(level));
  for (std::size_t largest = 0; largest < 3; ++largest) {
    for (std::size_t next = 0; next < resolution_; ++next) {
      for (std::size_t after_next = 0; after_next < resolution_; ++after_next)
        fit_levels({largest, 0, next, after_next});
    }
  }
}

std::size_t SigmoidTable::index(const Place& place) const {
  return ((place.largest * resolution_ + place.level) * resolution_ + place.next) * resolution_ +
         place.after_next;
}

Triple SigmoidTable::fit(const Place& place, const Triple& start) {
  // White has an infinite coefficient; with this one it is darker by 1e-4.
  constexpr double kWhite = 50;
  const double level = levels_[place.level];
  Triple rgb, found;
  rgb[place.largest] = level;
  rgb[(place.largest + 1) % 3] = level * ratios_[place.next];
  rgb[(place.largest + 2) % 3] = level * ratios_[place.after_next];
  if (rgb[0] == rgb[1] && rgb[1] == rgb[2]) {
    found = {0, 0, std::min(inverse_sigmoid(level), kWhite)};
  } else {
    found = fit_sigmoid(rgb, start).coefficients;
  }
  entries_[index(place)] = {static_cast<float>(found[0]), static_cast<float>(found[1]),
                            static_cast<float>(found[2])};
  return found;
}

void SigmoidTable::fit_levels(Place place) {
  // From the middle to black and to white: each fit starts where the one before ended.
  const std::size_t middle = resolution_ / 2;
  place.level = middle;
  const Triple at_middle = fit(place, {0, 0, 0});
  Triple last = at_middle;
  for (place.level = middle; place.level-- > 0;) last = fit(place, last);
  last = at_middle;
  for (place.level = middle + 1; place.level < resolution_; ++place.level) last = fit(place, last);
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
  const TableCell level = cell_of(along_levels_, along(std::max(v[largest], kDarkest)));
  const TableCell next = cell_of(ratios_, v[(largest + 1) % 3] / v[largest]);
  const TableCell after_next = cell_of(ratios_, v[(largest + 2) % 3] / v[largest]);
  const auto weight = [](const TableCell& cell, std::size_t high) {
    return high == 1 ? cell.weight_of_high : 1 - cell.weight_of_high;
  };
  Triple sum = {0, 0, 0};
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const std::size_t up = corner >> 2, right = corner >> 1 & 1, front = corner & 1;
    const SigmoidCoefficients& entry =
        entries_[index({largest, level.low + up, next.low + right, after_next.low + front})];
    const double w = weight(level, up) * weight(next, right) * weight(after_next, front);
    sum[0] += w * entry.c0;
    sum[1] += w * entry.c1;
    sum[2] += w * entry.c2;
  }
  return {static_cast<float>(sign * sum[0]), static_cast<float>(sign * sum[1]),
          static_cast<float>(sign * sum[2])};
}

}  // namespace tessera::spectra
