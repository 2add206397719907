// Sampling pixel filters, wide.
#pragma once

#include "render/core/vec.h"
#include "render/film/pixel_filter.h"

namespace tessera::render::TESSERA_ISA {

struct FilterSample {
  Vec2 offset;   // pixels from the pixel's centre
  Float weight;  // f / pdf; 1 for filters that are nowhere negative
};

namespace detail {

TESSERA_INLINE Float sample_axis(FilterKind kind, const FilterAxis& axis, Float u, Float& weight) {
  const Float radius(axis.radius);
  if (kind == FilterKind::kBox) return (u * 2.0f - 1.0f) * radius;
  if (kind == FilterKind::kTriangle) {
    const Mask left = u < 0.5f;
    const Float v = select(left, u, 1.0f - u);
    const Float x = (sqrt(v * 2.0f) - 1.0f) * radius;
    return select(left, x, -x);
  }
  // The bin whose part of the CDF holds u, by bisection; then a place within it.
  Int low(0);
  for (int step = static_cast<int>(axis.weight.size()) / 2; step > 0; step /= 2) {
    const Int middle = low + step;
    low = select(gather(axis.cdf.data(), middle) <= u, middle, low);
  }
  const Float begin = gather(axis.cdf.data(), low), end = gather(axis.cdf.data() + 1, low);
  weight = weight * gather(axis.weight.data(), low);
  const Float inside = (u - begin) / max(end - begin, 1e-30f);
  return ((to_float(low) + clamp(inside, 0.0f, 1.0f)) * (2.0f / static_cast<float>(axis.weight.size())) -
          1.0f) *
         radius;
}

}  // namespace detail

TESSERA_INLINE FilterSample sample_filter(const PixelFilterRecord& filter, Vec2 u) {
  FilterSample s;
  s.weight = Float(1.0f);
  s.offset.x = detail::sample_axis(filter.kind, filter.x, u.x, s.weight);
  s.offset.y = detail::sample_axis(filter.kind, filter.y, u.y, s.weight);
  return s;
}

}  // namespace tessera::render::TESSERA_ISA
