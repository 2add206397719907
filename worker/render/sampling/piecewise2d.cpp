#include "render/sampling/piecewise2d.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

namespace tessera::render {
namespace {

double usable(float weight) { return std::isfinite(weight) && weight > 0 ? weight : 0.0; }

/// Writes values.size() + 1 values from 0 to exactly 1; the values' sum is not zero.
void write_cdf(std::span<const double> values, double sum, float* cdf) {
  double running = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    cdf[i] = static_cast<float>(std::min(running / sum, 1.0));
    running += values[i];
  }
  // From the last outcome with any weight on, so that u just below 1 cannot fall on one without.
  std::size_t end = values.size();
  while (end > 0 && values[end - 1] == 0) --end;
  for (std::size_t i = end; i <= values.size(); ++i) cdf[i] = 1;
}

/// An entry for about every eight cells: the search that is left stays within a cache line.
std::int32_t guides_for(std::int32_t cells) {
  return static_cast<std::int32_t>(std::bit_ceil(static_cast<std::uint32_t>((cells + 7) / 8))) + 1;
}

void append_guide(const float* cdf, std::int32_t cells, std::int32_t guides, BigArray<std::int32_t>& out) {
  std::int32_t cell = 0;
  for (std::int32_t k = 0; k < guides; ++k) {
    const float u = static_cast<float>(k) / static_cast<float>(guides - 1);
    while (cell + 1 < cells && cdf[cell + 1] <= u) ++cell;
    out.push_back(cell);
  }
}

}  // namespace

Piecewise2d Piecewise2d::build(std::span<const float> weights, std::int32_t width, std::int32_t height) {
  const auto columns = static_cast<std::size_t>(width), rows = static_cast<std::size_t>(height);
  assert(width > 0 && height > 0 && weights.size() == columns * rows);
  Piecewise2d result;
  result.width = width;
  result.height = height;
  result.marginal_cdf.resize(rows + 1);
  result.conditional_cdf.resize(rows * (columns + 1));
  result.density.resize(rows * columns);

  std::vector<double> row(columns), row_sums(rows);
  for (std::size_t y = 0; y < rows; ++y)
    for (std::size_t x = 0; x < columns; ++x) row_sums[y] += usable(weights[y * columns + x]);
  double total = 0;
  for (const double s : row_sums) total += s;
  const bool uniform = total == 0;
  if (uniform) {
    row_sums.assign(rows, static_cast<double>(columns));
    total = static_cast<double>(rows * columns);
  }

  write_cdf(row_sums, total, result.marginal_cdf.data());
  result.marginal_guides = guides_for(height);
  result.conditional_guides = guides_for(width);
  append_guide(result.marginal_cdf.data(), height, result.marginal_guides, result.marginal_guide);
  const double cells = static_cast<double>(rows * columns);
  for (std::size_t y = 0; y < rows; ++y) {
    for (std::size_t x = 0; x < columns; ++x) {
      row[x] = uniform ? 1 : usable(weights[y * columns + x]);
      result.density[y * columns + x] = static_cast<float>(row[x] / total * cells);
    }
    // A row that is never chosen needs a CDF all the same: the binary search relies on its ends.
    if (row_sums[y] == 0) std::fill(row.begin(), row.end(), 1.0);
    const double sum = row_sums[y] == 0 ? static_cast<double>(columns) : row_sums[y];
    write_cdf(row, sum, &result.conditional_cdf[y * (columns + 1)]);
    append_guide(&result.conditional_cdf[y * (columns + 1)], width, result.conditional_guides,
                 result.conditional_guide);
  }
  return result;
}

}  // namespace tessera::render
