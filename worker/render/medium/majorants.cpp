#include <algorithm>
#include <cmath>

#include "render/medium/medium_table.h"

namespace tessera::render {

namespace {

constexpr std::int32_t kMostCells = 32;  // along an axis

/// The samples, along one axis, that interpolation looks at between `low` and `high` of the unit interval.
struct Range {
  std::int32_t first, last;

  Range(double low, double high, std::int32_t size)
      : first(std::clamp(static_cast<std::int32_t>(std::floor(low * size - 0.5)), 0, size - 1)),
        last(std::clamp(static_cast<std::int32_t>(std::floor(high * size - 0.5)) + 1, 0, size - 1)) {}
};

float largest(const DensityGrid& grid, const MediumValue& value, Range x, Range y, Range z) {
  float result = 0;
  for (std::int32_t k = z.first; k <= z.last; ++k) {
    for (std::int32_t j = y.first; j <= y.last; ++j) {
      for (std::int32_t i = x.first; i <= x.last; ++i) {
        const std::size_t at = (static_cast<std::size_t>(k) * grid.size[1] + j) * grid.size[0] + i;
        for (int c = 0; c < kBands; ++c) {
          const float sample = grid.samples[at * grid.channels + (grid.channels == kBands ? c : 0)];
          result = std::max(result, sample * value.value[c]);
        }
      }
    }
  }
  return result;
}

}  // namespace

void build_majorants(const MediumTable& table, MediumRecord& medium) {
  const MediumValue& sigma_t = medium.sigma_t;
  if (sigma_t.grid < 0) {
    // Only the albedo or the emission varies.
    medium.majorants = {std::max({sigma_t.value[0], sigma_t.value[1], sigma_t.value[2]})};
    return;
  }
  const DensityGrid& grid = table.grids[sigma_t.grid];
  if (!std::ranges::equal(medium.bounds_from_render.m, grid.grid_from_render.m)) {
    // Bounds of another shape: one majorant for all.
    const auto all = [&](int axis) { return Range(0, 1, grid.size[axis]); };
    medium.majorants = {largest(grid, sigma_t, all(0), all(1), all(2))};
    return;
  }
  // The grid of sigma_t is what bounds the medium, so that cells of one are cells of the other.
  for (int axis = 0; axis < 3; ++axis) medium.cells[axis] = std::min(grid.size[axis], kMostCells);
  const auto range = [&](int axis, std::int32_t cell) {
    const double n = medium.cells[axis];
    return Range(cell / n, (cell + 1) / n, grid.size[axis]);
  };
  medium.majorants.clear();
  for (std::int32_t k = 0; k < medium.cells[2]; ++k) {
    for (std::int32_t j = 0; j < medium.cells[1]; ++j) {
      for (std::int32_t i = 0; i < medium.cells[0]; ++i) {
        medium.majorants.push_back(largest(grid, sigma_t, range(0, i), range(1, j), range(2, k)));
      }
    }
  }
}

}  // namespace tessera::render
