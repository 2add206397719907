// Reading the grids of media, 16 points at a time.
#pragma once

#include "render/color/spectra.h"
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
TESSERA_INLINE Color grid_at(const DensityGrid& grid, Vec3 p, Mask active) {
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
  if (grid.channels != kBands) return Color(channel(0));
  return color_of(channel);
}

/// Whether a quantity is one of colours.
TESSERA_INLINE bool has_colors(const MediumTable& table, const MediumValue& value) {
  return value.grid >= 0 && table.grids[static_cast<std::size_t>(value.grid)].channels == kBands;
}

TESSERA_INLINE Color color_at(const MediumTable& table, const MediumValue& value, Vec3 p, Mask active) {
  const Color color = color_of(value.value);
  return value.grid < 0 ? color
                        : color * grid_at(table.grids[static_cast<std::size_t>(value.grid)], p, active);
}

/// The extinction; or the scattering or the albedo of a medium whose grids have no colours.
TESSERA_INLINE Spectrum density_at(const MediumTable& table, const MediumValue& value, const Spectra& spectra,
                                   Vec3 p, Mask active) {
  const Spectrum result = spectra.constant(color_of(value.value), Int(value.curve), active);
  if (value.grid < 0) return result;
  const Color factor = grid_at(table.grids[static_cast<std::size_t>(value.grid)], p, active);
  return has_colors(table, value) ? result * spectra.density(factor, active) : result * factor.c[0];
}

TESSERA_INLINE Spectrum emission_at(const MediumTable& table, const MediumValue& value,
                                    const Spectra& spectra, Vec3 p, Mask active) {
  return spectra.light(color_at(table, value, p, active), Int(value.curve), active);
}

}  // namespace tessera::render::TESSERA_ISA
