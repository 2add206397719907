// A piecewise-constant distribution over the unit square: rows by a marginal CDF, columns by conditional
// CDFs.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/core/big_array.h"

namespace tessera::render {

/// Plain arrays that the kernels gather from; see sampling/piecewise2d_sample.h for the wide side.
struct Piecewise2d {
  std::int32_t width = 0, height = 0;
  std::vector<float> marginal_cdf;  // height + 1 values from 0 to 1
  BigArray<float> conditional_cdf;  // height rows of width + 1 values from 0 to 1
  BigArray<float> density;          // width * height; integrates to 1 over the unit square
  // Where to look in a CDF: entry k of a row's guide is the cell in which k / (entries - 1) lies [Chen & Asau
  // 1974].
  std::int32_t marginal_guides = 0, conditional_guides = 0;  // entries of a row, a power of two plus one
  BigArray<std::int32_t> marginal_guide;                     // guide of the one marginal row
  BigArray<std::int32_t> conditional_guide;                  // height rows

  /// `weights` are row-major, rows from v = 0 on; not normalised. Negative or non-finite weights count as
  /// zero; all zero: uniform.
  static Piecewise2d build(std::span<const float> weights, std::int32_t width, std::int32_t height);
};

}  // namespace tessera::render
