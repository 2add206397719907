// The wide side of sampling/piecewise2d.h.
#pragma once

#include "render/core/constants.h"
#include "render/core/vec.h"
#include "render/sampling/piecewise2d.h"

namespace tessera::render::TESSERA_ISA {

struct Piecewise2dPlace {
  Vec2 uv;   // a point of [0, 1)^2
  Int x, y;  // the cell that uv lies in
};

struct Piecewise2dSample : Piecewise2dPlace {
  Float density;  // density of uv over the unit square
};

namespace detail {

/// A place in a CDF: a cell and how far into it.
struct CdfPlace {
  Int cell;
  Float offset;  // [0, 1)
};

/// Inverts the CDF whose values begin at cdf[first], by bisection between two entries of its guide.
TESSERA_INLINE CdfPlace invert_cdf(const float* cdf, Int first, const std::int32_t* guide, Int first_guide,
                                   std::int32_t guides, Float u, Mask active) {
  // The last cell whose lower end is <= u: cells of no weight, whose ends coincide, are passed over.
  const Int k = first_guide + to_int(u * static_cast<float>(guides - 1));
  Int low = gather(guide, k, active), high = gather(guide, k + 1, active) + 1;
  for (Mask open = active & (high - low > 1); any(open); open &= high - low > 1) {
    const Int middle = shift_right<1>(low + high);
    const Mask above = gather(cdf, first + middle, open) <= u;
    low = select(open & above, middle, low);
    high = select(and_not(open, above), middle, high);
  }
  const Float c0 = gather(cdf, first + low, active);
  const Float c1 = gather(cdf, first + low + 1, active);
  const Float span = c1 - c0;
  return {low, clamp((u - c0) / select(span > 0.0f, span, 1.0f), 0.0f, kOneMinusEpsilon)};
}

}  // namespace detail

/// A point of the unit square, distributed as `p`; `u` is uniform in [0, 1)^2.
TESSERA_INLINE Piecewise2dPlace locate_piecewise2d(const Piecewise2d& p, Vec2 u, Mask active) {
  const detail::CdfPlace row = detail::invert_cdf(p.marginal_cdf.data(), Int(0), p.marginal_guide.data(),
                                                  Int(0), p.marginal_guides, u.y, active);
  const detail::CdfPlace column =
      detail::invert_cdf(p.conditional_cdf.data(), row.cell * (p.width + 1), p.conditional_guide.data(),
                         row.cell * p.conditional_guides, p.conditional_guides, u.x, active);
  const Vec2 uv = {(to_float(column.cell) + column.offset) * (1.0f / static_cast<float>(p.width)),
                   (to_float(row.cell) + row.offset) * (1.0f / static_cast<float>(p.height))};
  return {{min(uv.x, kOneMinusEpsilon), min(uv.y, kOneMinusEpsilon)}, column.cell, row.cell};
}

/// The same with its density there.
TESSERA_INLINE Piecewise2dSample sample_piecewise2d(const Piecewise2d& p, Vec2 u, Mask active) {
  const Piecewise2dPlace place = locate_piecewise2d(p, u, active);
  return {place, gather(p.density.data(), place.y * p.width + place.x, active)};
}

/// The density at `uv` in [0, 1]^2.
TESSERA_INLINE Float piecewise2d_density(const Piecewise2d& p, Vec2 uv, Mask active) {
  const Int x = clamp(to_int(uv.x * static_cast<float>(p.width)), 0, p.width - 1);
  const Int y = clamp(to_int(uv.y * static_cast<float>(p.height)), 0, p.height - 1);
  return gather(p.density.data(), y * p.width + x, active);
}

}  // namespace tessera::render::TESSERA_ISA
