// Cells of space in which paths learn where light comes from: cubes whose sides grow with their distance from
// the camera in powers of two, so that they are alike on the film [Binder, Fricke & Keller 2019], apart for
// the six directions that surfaces mostly face.
//
// Directions are cells of the unit square of the equal-area octahedral map (sampling/sphere_map.h).
#pragma once

#include <cstdint>

#include "render/core/vec.h"
#include "render/sampling/sphere_map.h"
#include "wire/phases/guide_sums.h"

namespace tessera::render::TESSERA_ISA {

using wire::kGuideBins;
using wire::kGuideRows;
namespace guide_key = wire::guide_key;

/// Cells have a side of this part of their distance, or half of it.
inline constexpr float kGuideCellSize = 1.0f / 8;
/// A cell is merged with its neighbours this often at most: eight make one.
inline constexpr int kGuideMerges = 4;

/// Where it pays, paths follow the guide with this probability; else, and the rest of the time, the BSDF.
inline constexpr float kGuideFraction = 0.5f;

/// Cells of 16 points.
struct GuideCells {
  Int size_exponent;  // cells are 2^size_exponent wide
  Int x, y, z;        // counted in cells from the camera
  Int side;           // 0 to 5: +x, -x, +y, -y, +z, -z
};

/// The cells of points `p`, seen from the camera at 0, moved by up to half a side along the surface, whose
/// normal is `n`, as `u` in [0, 1)^2 says: so the borders of cells do not show.
TESSERA_INLINE GuideCells guide_cells_at(Vec3 p, Vec3 n, Vec2 u) {
  const Float distance = max(length(p), 1e-30f) * kGuideCellSize;
  GuideCells cells;
  cells.size_exponent = (shift_right<23>(bit_cast<std::int32_t>(distance)) & 255) - 127;
  const Float side = bit_cast<float>(shift_left<23>(max(cells.size_exponent, -126) + 127));
  const Float per_side = 1.0f / side;
  const Vec3 a = abs(n);
  const Mask along_x = (a.x >= a.y) & (a.x >= a.z), along_y = and_not(a.y >= a.z, along_x);
  const Mask along_z = and_not(~along_x, along_y);
  const Float u1 = u.x - 0.5f, u2 = u.y - 0.5f;
  const auto place = [&](Float x, Float shift, Mask along) {
    return to_int(floor(fma(x, per_side, select(along, Float(0.0f), shift))));
  };
  cells.x = place(p.x, u1, along_x);
  cells.y = place(p.y, select(along_x, u1, u2), along_y);
  cells.z = place(p.z, u2, along_z);
  const Float facing = select(along_x, n.x, select(along_y, n.y, n.z));
  cells.side =
      select(along_x, Int(0), select(along_y, Int(2), Int(4))) + select(facing < 0.0f, Int(1), Int(0));
  return cells;
}

/// The bins of directions.
TESSERA_INLINE Int guide_bin(Vec3 w) {
  const Vec2 uv = octahedral_from_direction(w);
  const auto cell = [](Float x) {
    return min(to_int(x * static_cast<float>(kGuideRows)), Int(kGuideRows - 1));
  };
  return cell(uv.y) * kGuideRows + cell(uv.x);
}

}  // namespace tessera::render::TESSERA_ISA
