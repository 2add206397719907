#include "render/textbook/irradiance_cache/hemisphere.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/core/constants.h"

namespace tessera::render::TESSERA_ISA {

namespace {

int rings_of(int samples) {
  return std::max(static_cast<int>(std::lround(std::sqrt(samples * double{kInvPi}))), 1);
}

/// f(0) .. f(n - 1).
template <class F>
std::vector<float> tabulate(int n, F&& f) {
  std::vector<float> table(static_cast<std::size_t>((n + kWidth - 1) / kWidth * kWidth));
  for (int i = 0; i < n; i += kWidth) f(to_float(Int::iota(i))).store_unaligned(table.data() + i);
  return table;
}

/// The integral of tan(theta) over the squared sine from 0 to u.
Float tangent_integral(Float u) { return asin(safe_sqrt(u)) - safe_sqrt(u * (1.0f - u)); }

/// How fast the border between what is `near` and what is `far` moves, were they alone: that of the nearer.
double inverse_of_nearer(float a, float b) { return 1 / double{std::min(a, b)}; }

}  // namespace

Hemisphere::Hemisphere(int samples)
    : rings_(rings_of(samples)), sectors_(std::max(samples / rings_of(samples), 3)) {
  const auto cells = static_cast<std::size_t>(this->cells());
  for (std::vector<float>& band : radiance_) band.resize(cells);
  distance_.resize(cells);
  const float angle = 2 * kPi / static_cast<float>(sectors_), share = 1 / static_cast<float>(rings_);
  border_x_ = tabulate(sectors_, [&](Float k) { return cos(k * angle); });
  border_y_ = tabulate(sectors_, [&](Float k) { return sin(k * angle); });
  middle_x_ = tabulate(sectors_, [&](Float k) { return cos((k + 0.5f) * angle); });
  middle_y_ = tabulate(sectors_, [&](Float k) { return sin((k + 0.5f) * angle); });
  tangent_ = tabulate(rings_, [&](Float j) {
    return (tangent_integral(min((j + 1.0f) * share, 1.0f)) - tangent_integral(min(j * share, 1.0f))) *
           static_cast<float>(rings_);
  });
}

Vec3 Hemisphere::direction(Int cell, Vec2 u) const {
  // Exact below 2^24 cells.
  const Float number = to_float(cell);
  const Float ring = floor((number + 0.5f) * (1 / static_cast<float>(sectors_)));
  const Float sector = number - ring * static_cast<float>(sectors_);
  const Float sine_squared = min((ring + u.x) * (1 / static_cast<float>(rings_)), kOneMinusEpsilon);
  const Float azimuth = (sector + u.y) * (2 * kPi / static_cast<float>(sectors_));
  const Float sine = sqrt(sine_squared);
  return {sine * cos(azimuth), sine * sin(azimuth), sqrt(1.0f - sine_squared)};
}

void Hemisphere::set(int cell, const float (&radiance)[kBands], float distance) {
  const auto i = static_cast<std::size_t>(cell);
  for (int band = 0; band < kBands; ++band) radiance_[band][i] = radiance[band];
  distance_[i] = distance;
}

/// Adds what a cell and its borders with the one before it, in its ring and in its sector, contribute.
void Hemisphere::add_cell(int ring, int sector, Estimate& sum) const {
  const auto k = static_cast<std::size_t>(sector);
  const std::size_t cell = at(ring, sector), beside = at(ring, sector == 0 ? sectors_ - 1 : sector - 1);
  const double rings = rings_, weight = double{kPi} / cells();
  const double lower = std::sqrt(ring / rings), upper = std::sqrt((ring + 1) / rings);  // sines
  const double beside_rate = (upper - lower) * inverse_of_nearer(distance_[cell], distance_[beside]);
  const double below_rate = ring == 0
                                ? 0
                                : 2 * double{kPi} / sectors_ * lower * (1 - ring / rings) *
                                      inverse_of_nearer(distance_[cell], distance_[at(ring - 1, sector)]);
  const double turn = weight * double{tangent_[static_cast<std::size_t>(ring)]};
  for (int band = 0; band < kBands; ++band) {
    const std::vector<float>& radiance = radiance_[band];
    const double here = double{radiance[cell]};
    sum.irradiance[band] += weight * here;
    // The normal turns towards the cell about the axis a quarter of a turn ahead of it.
    sum.rotation[band][0] -= turn * here * double{middle_y_[k]};
    sum.rotation[band][1] += turn * here * double{middle_x_[k]};
    const double step_beside = (here - double{radiance[beside]}) * beside_rate;
    const double step_below = ring == 0 ? 0 : (here - double{radiance[at(ring - 1, sector)]}) * below_rate;
    sum.translation[band][0] += step_below * double{middle_x_[k]} - step_beside * double{border_y_[k]};
    sum.translation[band][1] += step_below * double{middle_y_[k]} + step_beside * double{border_x_[k]};
  }
}

Hemisphere::Estimate Hemisphere::estimate() const {
  Estimate sum{};
  sum.nearest = std::numeric_limits<double>::infinity();
  double inverse_distances = 0;
  for (int ring = 0; ring < rings_; ++ring) {
    for (int sector = 0; sector < sectors_; ++sector) {
      add_cell(ring, sector, sum);
      const double distance = double{distance_[at(ring, sector)]};
      inverse_distances += 1 / distance;
      sum.nearest = std::min(sum.nearest, distance);
    }
  }
  sum.mean_distance =
      inverse_distances > 0 ? cells() / inverse_distances : std::numeric_limits<double>::infinity();
  return sum;
}

}  // namespace tessera::render::TESSERA_ISA
