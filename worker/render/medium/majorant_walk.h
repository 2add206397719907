// Tentative collisions along rays through a grid of majorants, cell by cell [Amanatides & Woo 1987].
#pragma once

#include "render/core/affine.h"
#include "render/medium/medium_table.h"

namespace tessera::render::TESSERA_ISA {

class MajorantWalk {
 public:
  /// Rays are `distance` long at most; parts outside the medium's bounds are empty.
  TESSERA_INLINE MajorantWalk(const MediumRecord& medium, Vec3 origin, Vec3 direction, Float distance,
                              Mask active)
      : medium_(medium) {
    const Vec3 o = transform_point(medium.bounds_from_render, origin);
    const Vec3 d = transform_vector(medium.bounds_from_render, direction);
    const Float from[3] = {o.x, o.y, o.z}, along[3] = {d.x, d.y, d.z};
    t_ = Float(0.0f);
    end_ = distance;
    Mask meets = active;
    for (int a = 0; a < 3; ++a) {
      const Mask moves = abs(along[a]) > kStill;
      const Float inverse = 1.0f / select(moves, along[a], 1.0f);
      const Float t0 = (0.0f - from[a]) * inverse, t1 = (1.0f - from[a]) * inverse;
      t_ = select(moves, max(t_, min(t0, t1)), t_);
      end_ = select(moves, min(end_, max(t0, t1)), end_);
      meets &= moves | ((from[a] >= 0.0f) & (from[a] <= 1.0f));
    }
    active_ = meets & (t_ < end_);
    for (int a = 0; a < 3; ++a) start_axis(a, from[a], along[a]);
  }

  /// Moves every lane that still runs to its next tentative collision, `u` uniform in [0, 1), and says which
  /// met one; the others have come to their ends.
  TESSERA_INLINE Mask advance(Float u) {
    Float depth = -log(1.0f - u);  // optical depth to go
    Mask moving = active_;
    while (any(moving)) {
      const Int index = (cell_[2] * medium_.cells[1] + cell_[1]) * medium_.cells[0] + cell_[0];
      const Float majorant = gather(medium_.majorants.data(), index, moving);
      const Float wall = min(min(next_[0], next_[1]), next_[2]);
      const Float leave = min(wall, end_);
      const Float crossing = max(leave - t_, 0.0f) * majorant;
      const Mask collides = moving & (majorant > 0.0f) & (depth < crossing);
      t_ =
          select(collides, t_ + depth / select(collides, majorant, 1.0f), select(moving, max(leave, t_), t_));
      majorant_ = select(collides, majorant, majorant_);
      moving = and_not(moving, collides);
      depth = depth - select_or_zero(moving, crossing);
      const Mask ends = moving & (wall >= end_);
      active_ = and_not(active_, ends);
      moving = and_not(moving, ends);
      step(moving, wall);
      moving &= active_;
    }
    return active_;
  }

  TESSERA_INLINE void stop(Mask lanes) { active_ = and_not(active_, lanes); }
  TESSERA_INLINE Float t() const { return t_; }
  /// Majorant of the cell of the latest collision; 1 for lanes that never collided.
  TESSERA_INLINE Float majorant() const { return majorant_; }

 private:
  /// Slower than this along an axis, no wall is ever met; its inverse is still finite.
  static constexpr float kStill = 1e-25f;

  TESSERA_INLINE void start_axis(int a, Float from, Float along) {
    const float n = static_cast<float>(medium_.cells[a]);
    const Float at = (from + along * t_) * n;
    cell_[a] = min(max(to_int(floor(clamp(at, 0.0f, n))), 0), medium_.cells[a] - 1);
    const Mask moves = active_ & (abs(along) > kStill);
    const Mask up = along > 0.0f;
    const Float inverse = 1.0f / select(moves, along, 1.0f);
    const Float wall = to_float(select(up, cell_[a] + 1, cell_[a])) * (1.0f / n);
    next_[a] = select(moves, (wall - from) * inverse, Float(1e30f));
    delta_[a] = select(moves, abs(inverse) * (1.0f / n), Float(1e30f));
    stride_[a] = select(up, Int(1), Int(-1));
  }
  /// Into the cell behind `wall`. Rays that leave the last cell have come to their ends, whatever rounding
  /// says of `t`: far from a small medium a step may be too short to change it.
  TESSERA_INLINE void step(Mask moving, Float wall) {
    for (int a = 0; a < 3; ++a) {
      const Mask crosses = moving & (next_[a] <= wall);
      next_[a] = select(crosses, next_[a] + delta_[a], next_[a]);
      cell_[a] = select(crosses, cell_[a] + stride_[a], cell_[a]);
      active_ = and_not(active_, crosses & ((cell_[a] < 0) | (cell_[a] >= medium_.cells[a])));
    }
  }

  const MediumRecord& medium_;
  Mask active_;
  Float t_, end_;
  Float majorant_ = Float(1.0f);
  Int cell_[3], stride_[3];
  Float next_[3], delta_[3];
};

}  // namespace tessera::render::TESSERA_ISA
