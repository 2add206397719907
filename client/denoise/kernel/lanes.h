// Sixteen floats, as a compiler's own vectors: whatever instructions a source is compiled for, it gets wide
// ones where there are any.
#pragma once

namespace tessera::client::denoise {

using Lanes [[gnu::vector_size(64)]] = float;
using Places [[gnu::vector_size(64)]] = int;
inline constexpr int kLanes = 16;

namespace lanes {

using Loose [[gnu::vector_size(64), gnu::aligned(4), gnu::may_alias]] = float;

[[gnu::always_inline]] inline Lanes load(const float* from) { return *reinterpret_cast<const Loose*>(from); }
[[gnu::always_inline]] inline void store(const Lanes& value, float* to) {
  *reinterpret_cast<Loose*>(to) = value;
}
[[gnu::always_inline]] inline Lanes all(float value) { return Lanes{} + value; }
[[gnu::always_inline]] inline Lanes smaller(const Lanes& a, const Lanes& b) { return a < b ? a : b; }
[[gnu::always_inline]] inline Lanes larger(const Lanes& a, const Lanes& b) { return a > b ? a : b; }

/// About exp(-x) for x >= 0: (1 + x / 16)^-16, which falls as gently as it does and never to nothing.
[[gnu::always_inline]] inline Lanes falling(const Lanes& x) {
  Lanes power = 1.0f / (1.0f + x * 0.0625f);
  power *= power;
  power *= power;
  power *= power;
  return power * power;
}

/// Adds in the order of a tree.
[[gnu::always_inline]] inline float sum(const Lanes& value) {
  float part[kLanes];
  store(value, part);
  for (int width = kLanes / 2; width > 0; width /= 2) {
    for (int i = 0; i < width; ++i) part[i] += part[i + width];
  }
  return part[0];
}

}  // namespace lanes
}  // namespace tessera::client::denoise
