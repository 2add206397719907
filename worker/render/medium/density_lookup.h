// Reading the grids of media, 16 points at a time.
#pragma once

#include "render/color/spectrum.h"
#include "render/core/affine.h"
#include "render/medium/medium_table.h"

namespace tessera::render::TESSERA_ISA {

/// Two neighbouring samples along one axis, and how far between them.
struct GridAxis {
  Int low, high;
  Float t;

  TESSERA_INLINE GridAxis(Float x, std::int32_t size) {
    const Float at = clamp(x * static_cast<float>(size) - 0.5f, 0.0f, static_cast<float>(size - 1));
    const Float below = floor(at);
    low = to_int(below);
    high = min(low + 1, size - 1);
    t = at - below;
  }
};

/// Trilinear; `p` in render space, constant beyond the outer samples.
TESSERA_INLINE Spectrum grid_at(const DensityGrid& grid, Vec3 p, Mask active) {
  const Vec3 g = transform_point(grid.grid_from_render, p);
  const GridAxis x(g.x, grid.size[0]), y(g.y, grid.size[1]), z(g.z, grid.size[2]);
  const float* samples = grid.samples.data();
  const auto channel = [&](int c) {
    const auto along_x = [&](Int j, Int k) {
      const Int row = (k * grid.size[1] + j) * grid.size[0];
      return lerp(x.t, gather(samples + c, (row + x.low) * grid.channels, active),
                  gather(samples + c, (row + x.high) * grid.channels, active));
    };
    return lerp(z.t, lerp(y.t, along_x(y.low, z.low), along_x(y.high, z.low)),
                lerp(y.t, along_x(y.low, z.high), along_x(y.high, z.high)));
  };
  if (grid.channels != kBands) return Spectrum(channel(0));
  return spectrum_of(channel);
}

TESSERA_INLINE Spectrum density_at(const MediumTable& table, const MediumValue& value, Vec3 p, Mask active) {
  Spectrum result = spectrum_of(value.value);
  if (value.grid >= 0)
    result = result * grid_at(table.grids[static_cast<std::size_t>(value.grid)], p, active);
  return result;
}

}  // namespace tessera::render::TESSERA_ISA
