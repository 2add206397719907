#pragma once

#include <array>

#include "render/accel/grid/grid.h"
#include "render/accel/structure/ray.h"

namespace tessera::render::TESSERA_ISA {

/// Primitives that a ray has met lately, in whatever cell: those in several are tested once. Tags would stand
/// on the primitives themselves [Amanatides & Woo 1987, sec. 4] if it were not for other threads; a small
/// table for each ray does nearly as well [Wald, Slusallek, Benthin & Wagner 2001].
class Mailbox {
 public:
  Mailbox() { tags_.fill(~0u); }
  /// False where it knew the primitive already.
  bool add(std::uint32_t primitive) {
    std::uint32_t& tag = tags_[primitive % kTags];
    if (tag == primitive) return false;
    tag = primitive;
    return true;
  }

 private:
  static constexpr std::uint32_t kTags = 64;
  std::array<std::uint32_t, kTags> tags_;
};

/// From cell to cell through the nearest of three planes [Amanatides & Woo 1987]. Where the ray meets a plane
/// follows from the plane's number, in double, so that no error adds up; primitives lie in all cells
/// that they are close to (grid.cpp), which is the walk's room for rounding.
template <class Visitor>
void walk(const Grid& grid, const Box&, const Ray& ray, Visitor& visitor) {
  const Ray::Interval whole = ray.within(grid.box.low, grid.box.high);
  if (whole.empty() || whole.enter > visitor.reach()) return;
  double narrowest = grid.box.extent(0);
  for (int k = 1; k < 3; ++k) narrowest = std::min(narrowest, grid.box.extent(k));
  // From so far away, doubles do not hold a place within a cell.
  if (0x1p-28 * ray.pad > 0x1p-18 * narrowest) {
    for (std::uint32_t i = 0; i < grid.figures.primitives; ++i) {
      if (visitor.meet(i)) return;
    }
    return;
  }
  std::int32_t at[3], step[3];
  double leave[3], first[3], pace[3];  // the plane between cells i - 1 and i is met at first + i pace
  for (int k = 0; k < 3; ++k) {
    const double place = ray.o[k] + whole.enter * ray.d[k];
    const double cell = std::floor((place - grid.box.low[k]) * (grid.size[k] / grid.box.extent(k)));
    at[k] = static_cast<std::int32_t>(std::clamp(cell, 0.0, grid.size[k] - 1.0));
    step[k] = ray.d[k] < 0 ? -1 : 1;
    first[k] = ray.d[k] == 0 ? HUGE_VAL : (grid.box.low[k] - ray.o[k]) / ray.d[k];
    pace[k] = ray.d[k] == 0 ? 0 : grid.box.extent(k) / grid.size[k] / ray.d[k];
  }
  const auto plane_ahead = [&](int k) { return first[k] + (at[k] + (step[k] > 0)) * pace[k]; };
  for (int k = 0; k < 3; ++k) leave[k] = plane_ahead(k);
  Mailbox met;
  std::size_t cell = grid.cell(at[0], at[1], at[2]);
  for (;;) {
    visitor.enter();
    const std::uint32_t begin = grid.firsts[cell], end = grid.firsts[cell + 1];
    int axis = leave[0] < leave[1] ? 0 : 1;
    axis = leave[2] < leave[axis] ? 2 : axis;
    const double left = leave[axis];
    at[axis] += step[axis];
    const bool ends = at[axis] < 0 || at[axis] >= grid.size[axis];
    if (!ends) {
      cell = grid.cell(at[0], at[1], at[2]);
      __builtin_prefetch(&grid.firsts[cell]);  // it is on its way while this cell's primitives are met
    }
    for (std::uint32_t i = begin; i < end; ++i) {
      if (met.add(grid.items[i]) && visitor.meet(grid.items[i])) return;
    }
    // A distance that a float rounds to `reach` may be a little larger.
    if (ends || visitor.reach() * (1 + 0x1p-22) < left) return;
    leave[axis] = plane_ahead(axis);
  }
}

}  // namespace tessera::render::TESSERA_ISA
