// One voxel of a grid of signed distances, trilinear between its eight corners. Voxel space: the unit cube.
#pragma once

#include "render/core/vec.h"
#include "render/shape/shape_table.h"

namespace tessera::render::TESSERA_ISA {

struct SdfVoxel {
  Float corner[8];  // x + 2 y + 4 z

  TESSERA_INLINE SdfVoxel(const SdfGridRecord& grid, Int lower, Mask active) {
    const std::int32_t row = grid.size[0], slice = grid.size[0] * grid.size[1];
    for (int i = 0; i < 8; ++i) {
      corner[i] =
          gather(grid.samples.data() + (i & 1) + (i >> 1 & 1) * row + (i >> 2) * slice, lower, active);
    }
  }
  TESSERA_INLINE Float value(Vec3 p) const {
    const auto along_x = [&](int i) { return lerp(p.x, corner[i], corner[i + 1]); };
    return lerp(p.z, lerp(p.y, along_x(0), along_x(2)), lerp(p.y, along_x(4), along_x(6)));
  }
  /// Derivatives in voxel space.
  TESSERA_INLINE Vec3 gradient(Vec3 p) const {
    const auto difference = [&](int low, int step, int a, int b, Float u, Float v) {
      const auto edge = [&](int i) { return corner[low + i + step] - corner[low + i]; };
      return lerp(v, lerp(u, edge(0), edge(a)), lerp(u, edge(b), edge(a + b)));
    };
    return {difference(0, 1, 2, 4, p.y, p.z), difference(0, 2, 1, 4, p.x, p.z),
            difference(0, 4, 1, 2, p.x, p.y)};
  }
};

/// Grid coordinates (unit: a voxel) of object space.
TESSERA_INLINE Vec3 sdf_scale(const SdfGridRecord& grid) {
  return {Float(static_cast<float>(grid.size[0] - 1)), Float(static_cast<float>(grid.size[1] - 1)),
          Float(static_cast<float>(grid.size[2] - 1))};
}
TESSERA_INLINE Vec3 scaled(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }

/// Lower corner of voxel `lower` (an index of a sample), in grid coordinates.
TESSERA_INLINE Vec3 voxel_position(const SdfGridRecord& grid, Int lower) {
  // Exact: there are fewer than 2^24 samples along an edge, and the quotients are corrected.
  const auto divide = [](Int a, std::int32_t b, Int& rest) {
    Int q = to_int(to_float(a) * (1.0f / static_cast<float>(b)));
    rest = a - q * b;
    const Mask low = rest < 0, high = rest >= b;
    q = select(low, q - 1, select(high, q + 1, q));
    rest = select(low, rest + b, select(high, rest - b, rest));
    return q;
  };
  Int x, y;
  const Int yz = divide(lower, grid.size[0], x);
  const Int z = divide(yz, grid.size[1], y);
  return {to_float(x), to_float(y), to_float(z)};
}

}  // namespace tessera::render::TESSERA_ISA
