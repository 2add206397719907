// Affine maps that change while the shutter is open.
//
// A motion is a row of matrices at evenly spaced times, the first when the shutter opens, the last when it
// closes. In between, elements are interpolated linearly, here as in Embree, so that surfaces are where rays
// met them. scene/placement/motion.h sees to it that there are enough of them.
#pragma once

#include "render/core/affine.h"

namespace tessera::render::TESSERA_ISA {

struct MovedAffine {
  WideAffine map;
  Float
      shift;  // how large the translation's coordinates may be that `map` was computed from: for error bounds
};

/// The motion with steps [first, first + segments] of each active lane at its `time` in [0, 1]; `segments` is
/// at least 1 there.
inline MovedAffine affine_at(const Affine* steps, Int first, Int segments, Float time, Mask active) {
  const Float place = time * to_float(segments);
  const Int before = max(min(to_int(place), segments - 1), 0);
  const Float after_part = place - to_float(before), before_part = 1.0f - after_part;
  const Int row = (first + before) * 12;
  // Most packets are of one thing that moves: a load serves all of its lanes, where gathers take one each.
  const std::uint32_t lanes = active.bits();
  const std::int32_t common = lanes != 0 ? row.lane(__builtin_ctz(lanes)) : 0;
  const bool is_common = none(and_not(active, row == common));
  MovedAffine moved;
  moved.shift = Float(0.0f);
  for (int i = 0; i < 12; ++i) {
    const float* const from = steps->m + i;
    const Float a = is_common ? Float(from[common]) : gather(from, row, active),
                b = is_common ? Float(from[common + 12]) : gather(from + 12, row, active);
    moved.map.m[i] = fma(before_part, a, after_part * b);
    if (i % 4 == 3) moved.shift = max(moved.shift, fma(before_part, abs(a), after_part * abs(b)));
  }
  return moved;
}

}  // namespace tessera::render::TESSERA_ISA
