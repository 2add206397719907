// The value of a pixel filter, for samples that are not drawn from it.
#pragma once

#include <algorithm>
#include <cmath>

#include "render/film/pixel_filter.h"

namespace tessera::render {

/// At `x` pixels from the pixel's centre along one axis; integrates to 1.
inline float filter_value(FilterKind kind, const FilterAxis& axis, float x) {
  if (!(std::abs(x) <= axis.radius)) return 0;
  if (kind == FilterKind::kBox)
    return x < axis.radius ? 1 / (2 * axis.radius) : 0;  // a border belongs to one pixel
  if (kind == FilterKind::kTriangle) return (axis.radius - std::abs(x)) / (axis.radius * axis.radius);
  const auto bins = axis.weight.size();
  const auto bin =
      std::min(static_cast<std::size_t>((x / axis.radius + 1) / 2 * static_cast<float>(bins)), bins - 1);
  const float mass = axis.cdf[bin + 1] - axis.cdf[bin];
  return axis.weight[bin] * mass * static_cast<float>(bins) / (2 * axis.radius);
}

}  // namespace tessera::render
