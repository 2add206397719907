// Lines through the cells of an implicit surface's bounds: from one that the surface may cross to the next
// [Amanatides & Woo 1987].
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "render/shape/implicit/chord_function.h"

namespace tessera::render::TESSERA_ISA {

/// Parts of 16 chords, numbered from 0 to 1, that lie in marked cells. A surface without cells has one part,
/// the whole chord.
class CellWalk {
 public:
  CellWalk(const ImplicitRecord& surface, const ChordFunction& f) : surface_(surface) {
    if (surface.cells == 0) return;
    alignas(64) double from[3][kWidth], along[3][kWidth];
    f.from().x.store(from[0]), f.from().y.store(from[1]), f.from().z.store(from[2]);
    f.along().x.store(along[0]), f.along().y.store(along[1]), f.along().z.store(along[2]);
    const double last = surface.cells - 1;
    for (int a = 0; a < 3; ++a) {
      const double low = surface.low[a];
      const double per_cell = surface.cells / (double{surface.high[a]} - low);
      for (int i = 0; i < kWidth; ++i) {
        const double at = (from[a][i] - low) * per_cell, way = along[a][i] * per_cell;
        // A chord that is none, of a lane that is not active, may have no numbers.
        const double cell = at >= 0 ? std::min(std::floor(at), last) : 0;
        Lane& lane = lanes_[i];
        lane.cell[a] = static_cast<std::int32_t>(cell);
        lane.step[a] = way < 0 ? -1 : 1;
        lane.per_cell[a] = std::abs(1 / way);
        lane.leaves[a] = std::abs(way) > 1e-12 ? ((way < 0 ? cell : cell + 1) - at) / way : kNever;
      }
    }
  }

  /// Sets the next parts of the lanes `wanted`; returns those that have one.
  Mask next(Mask wanted, Double& begin, Double& length) {
    if (surface_.cells == 0) {
      begin = Double(0.0), length = Double(1.0);
      const Mask all = and_not(wanted, walked_);
      walked_ |= wanted;
      return all;
    }
    alignas(64) double begins[kWidth], lengths[kWidth];
    begin.store(begins), length.store(lengths);
    std::uint32_t found = 0;
    for (std::uint32_t bits = wanted.bits(); bits != 0; bits &= bits - 1) {
      const int i = __builtin_ctz(bits);
      if (next(lanes_[i], begins[i], lengths[i])) found |= 1u << i;
    }
    begin = Double::load(begins), length = Double::load(lengths);
    return Mask::from_bits(found);
  }

 private:
  static constexpr double kNever = 1e300;

  /// A place along a chord: the cell that is entered there, where each axis leaves it, and how wide it is.
  struct Lane {
    double leaves[3], per_cell[3];
    double at = 0;
    std::int32_t cell[3], step[3];
  };

  bool next(Lane& lane, double& begin, double& length) const {
    const std::int32_t n = surface_.cells;
    while (lane.at < 1) {
      const auto index = static_cast<std::size_t>((lane.cell[2] * n + lane.cell[1]) * n + lane.cell[0]);
      const double from = lane.at;
      const int a = lane.leaves[0] <= lane.leaves[1] ? (lane.leaves[0] <= lane.leaves[2] ? 0 : 2)
                                                     : (lane.leaves[1] <= lane.leaves[2] ? 1 : 2);
      // Beyond the last cell only roundings of the chord's end are left.
      const bool leaves =
          lane.leaves[a] < 1 && lane.cell[a] + lane.step[a] >= 0 && lane.cell[a] + lane.step[a] < n;
      lane.at = leaves ? std::max(from, lane.leaves[a]) : 1;
      if (leaves) {
        lane.cell[a] += lane.step[a];
        lane.leaves[a] += lane.per_cell[a];
      }
      if ((surface_.marked[index / 64] >> index % 64 & 1) != 0 && lane.at > from) {
        begin = from, length = lane.at - from;
        return true;
      }
    }
    return false;
  }

  const ImplicitRecord& surface_;
  Mask walked_ = Mask::none();
  Lane lanes_[kWidth];
};

}  // namespace tessera::render::TESSERA_ISA
