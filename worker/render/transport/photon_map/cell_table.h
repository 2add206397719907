// Points sorted into the cells of a grid that has no bounds, for queries of one radius [Teschner et al.
// 2003].
//
// A cell is as wide as a query, so that a query meets two cells along each axis. Cells have numbers in a
// table of about as many entries as there are points, and neighbours along x have neighbouring numbers: a
// query is four runs of points that lie side by side in memory. The number is linear in the cell's
// coordinates, hence the four runs of a query never share a cell, whatever else falls into these.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>

#include "render/core/big_array.h"
#include "render/core/wide.h"

namespace tessera::render::TESSERA_ISA {

class CellTable {
 public:
  /// Sorts the `x.size()` points with these coordinates, all finite, for queries of `radius`, which is finite
  /// and not negative: place[i] becomes where point i belongs. Points of a cell keep their order. Below 2^31
  /// of them.
  void build(std::span<const float> x, std::span<const float> y, std::span<const float> z, float radius,
             BigArray<std::int32_t>& place);

  /// Calls visit(begin, end) for runs of places that together hold every point within the radius of
  /// (x, y, z), each once, and others.
  template <class Visit>
  TESSERA_INLINE void for_each_run(float x, float y, float z, Visit&& visit) const {
    if (first_.empty()) return;
    const std::uint64_t base = number(cell(x - margin_), cell(y - margin_), cell(z - margin_));
    for (const std::uint64_t row : {std::uint64_t{0}, kAlongY, kAlongZ, kAlongY + kAlongZ}) {
      const std::uint64_t number = (base + row) & mask_;
      if (number < mask_) {
        visit(first_[number], first_[number + 2]);
      } else {
        visit(first_[mask_], first_[mask_ + 1]);
        visit(first_[0], first_[1]);
      }
    }
  }

 private:
  // Steps of the number from a cell to its neighbours along y and z.
  static constexpr std::uint64_t kAlongY = 0x9e3779b1u, kAlongZ = 0x85ebca77u;
  static constexpr int kLeastBits = 6, kMostBits = 22;  // bits of a number
  static constexpr bool rows_are_apart();

  /// Along one axis. Double precision holds it for points that are 2^40 radii away from the origin; further
  /// away floats are so far apart that only equal ones are near, and these share a cell.
  TESSERA_INLINE std::int64_t cell(double coordinate) const {
    constexpr double kFarthest = 0x1p60;
    const double scaled = std::floor(coordinate * cells_per_unit_);
    return static_cast<std::int64_t>(std::fmin(std::fmax(scaled, -kFarthest), kFarthest));
  }
  static TESSERA_INLINE std::uint64_t number(std::int64_t x, std::int64_t y, std::int64_t z) {
    return static_cast<std::uint64_t>(x) + kAlongY * static_cast<std::uint64_t>(y) +
           kAlongZ * static_cast<std::uint64_t>(z);
  }

  double cells_per_unit_ = 0;
  double margin_ = 0;  // the radius, and more than roundings of distances may add
  std::uint64_t mask_ = 0;
  /// Index at which the points of each number begin, and the end; empty: no points.
  BigArray<std::int32_t> first_;
  BigArray<std::uint32_t> of_point_;  // numbers; kept for their memory
};

}  // namespace tessera::render::TESSERA_ISA
