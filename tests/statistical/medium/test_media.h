// Media to test, with densities looked up and integrated in double precision.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include "render/medium/medium.h"
#include "support/kernel/double_point.h"

namespace tessera::render::TESSERA_ISA {

using test::Point;
using test::unit;

inline Vec3 wide(Point p) {
  return {Float(static_cast<float>(p.x)), Float(static_cast<float>(p.y)), Float(static_cast<float>(p.z))};
}

using Rgb3 = std::array<double, 3>;

/// Samples over three orders of magnitude, one in three zero (but for the first).
inline DensityGrid noise_grid(std::int32_t nx, std::int32_t ny, std::int32_t nz, std::int32_t channels,
                              const Affine& grid_from_render, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0, 1);
  DensityGrid grid;
  grid.size[0] = nx, grid.size[1] = ny, grid.size[2] = nz;
  grid.channels = channels;
  grid.grid_from_render = grid_from_render;
  for (std::int32_t i = 0; i < nx * ny * nz; ++i) {
    const bool empty = uniform(random) < 0.3f && i > 0;
    for (std::int32_t c = 0; c < channels; ++c) {
      grid.samples.push_back(empty ? 0.0f : std::pow(10.0f, 3 * uniform(random) - 2));
    }
  }
  return grid;
}

/// Trilinear between the centres of cells, constant beyond the outer ones, by the definition of the scene
/// format.
inline Rgb3 density(const DensityGrid& grid, Point p) {
  const auto& m = grid.grid_from_render.m;
  const double at[3] = {m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3],
                        m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
                        m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]};
  int low[3], high[3];
  double t[3];
  for (int a = 0; a < 3; ++a) {
    const double x = std::clamp(at[a] * grid.size[a] - 0.5, 0.0, grid.size[a] - 1.0);
    low[a] = static_cast<int>(x);
    high[a] = std::min(low[a] + 1, grid.size[a] - 1);
    t[a] = x - low[a];
  }
  Rgb3 result{};
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    int index[3];
    for (int a = 0; a < 3; ++a) {
      const bool upper = corner >> a & 1;
      weight *= upper ? t[a] : 1 - t[a];
      index[a] = upper ? high[a] : low[a];
    }
    const auto sample = static_cast<std::size_t>(
        ((index[2] * grid.size[1] + index[1]) * grid.size[0] + index[0]) * grid.channels);
    for (std::size_t c = 0; c < 3; ++c)
      result[c] += weight * grid.samples[sample + (grid.channels == 3 ? c : 0)];
  }
  return result;
}

inline bool within_bounds(const Affine& unit_from_render, Point p) {
  const auto& m = unit_from_render.m;
  for (int a = 0; a < 3; ++a) {
    const double x = m[4 * a] * p.x + m[4 * a + 1] * p.y + m[4 * a + 2] * p.z + m[4 * a + 3];
    if (x < 0 || x > 1) return false;
  }
  return true;
}

/// A value of the medium at a point, 0 outside of its bounds.
inline Rgb3 value_at(const MediumTable& table, const MediumRecord& medium, const MediumValue& value,
                     Point p) {
  if (!medium.homogeneous && !within_bounds(medium.bounds_from_render, p)) return {};
  Rgb3 result{1, 1, 1};
  if (value.grid >= 0) result = density(table.grids[static_cast<std::size_t>(value.grid)], p);
  for (std::size_t c = 0; c < 3; ++c) result[c] *= value.value[c];
  return result;
}

/// Mean that the estimators must give along one ray, by the midpoint rule.
struct Expected {
  Rgb3 transmittance{}, scattered{}, emitted{};
  std::vector<Rgb3> scattered_in_bin;  // equal parts of the ray
};

inline Expected integrate(const MediumTable& table, const MediumRecord& medium, Point o, Point d,
                          double distance, int bins) {
  constexpr int kSteps = 48000;
  const double h = distance / kSteps;
  Rgb3 depth{};
  Expected result;
  result.scattered_in_bin.resize(static_cast<std::size_t>(bins));
  for (int i = 0; i < kSteps; ++i) {
    const Point p = o + d * ((i + 0.5) * h);
    const Rgb3 sigma_t = value_at(table, medium, medium.sigma_t, p),
               albedo = value_at(table, medium, medium.albedo, p),
               emission = value_at(table, medium, medium.emission, p);
    for (std::size_t c = 0; c < 3; ++c) {
      const double sigma_s = medium.scattering_is_sigma_s ? albedo[c] : albedo[c] * sigma_t[c];
      const double through = std::exp(-depth[c] - 0.5 * sigma_t[c] * h);
      result.scattered_in_bin[static_cast<std::size_t>(i * bins / kSteps)][c] += through * sigma_s * h;
      result.scattered[c] += through * sigma_s * h;
      result.emitted[c] += through * (sigma_t[c] - sigma_s) * emission[c] * h;
      depth[c] += sigma_t[c] * h;
    }
  }
  for (std::size_t c = 0; c < 3; ++c) result.transmittance[c] = std::exp(-depth[c]);
  return result;
}

/// Mean and standard error of many numbers.
class Moments {
 public:
  void add(double x) { ++count_, sum_ += x, squares_ += x * x; }
  double mean() const { return sum_ / count_; }
  double error() const { return std::sqrt(std::max(0.0, squares_ / count_ - mean() * mean()) / count_); }

 private:
  double count_ = 0, sum_ = 0, squares_ = 0;
};

/// Uniform numbers for 16 lanes.
class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  Float next() {
    alignas(64) float lanes[kWidth];
    for (float& x : lanes) x = static_cast<float>(engine_() >> 8) * 0x1p-24f;
    return Float::load(lanes);
  }
  Vec2 next_2d() {
    const Float x = next();
    return {x, next()};
  }
  UInt next_key() {
    alignas(64) std::uint32_t lanes[kWidth];
    for (std::uint32_t& x : lanes) x = engine_();
    return UInt::load(lanes);
  }

 private:
  std::mt19937 engine_;
};

}  // namespace tessera::render::TESSERA_ISA
