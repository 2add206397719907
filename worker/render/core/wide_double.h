// Sixteen numbers of double precision: what needs more digits than a float, 16 rays at a time. Like wide.h,
// compiled once an ISA; a Double is twice as many native vectors as a Float.
#pragma once

#include <cstddef>

#include "render/core/wide.h"

namespace tessera::render::TESSERA_ISA {

using DoubleTag = hn::CappedTag<double, kWidth>;
inline constexpr int kDoublePartWidth = static_cast<int>(hn::MaxLanes(DoubleTag()));
inline constexpr int kDoubleParts = kWidth / kDoublePartWidth;
static_assert(kDoublePartWidth * kDoubleParts == kWidth);

/// One bit a lane, for selections among doubles; mask_of() and double_mask_of() lead to a Mask and back.
struct DoubleMask {
  hn::Mask<DoubleTag> v[kDoubleParts];
};

struct Double {
  hn::Vec<DoubleTag> v[kDoubleParts];

  Double() = default;
  TESSERA_INLINE Double(double x) {
    for (int i = 0; i < kDoubleParts; ++i) v[i] = hn::Set(DoubleTag(), x);
  }
  explicit TESSERA_INLINE Double(Float x) {
    const hn::Rebind<float, DoubleTag> half;
    alignas(64) float lanes[kWidth];
    x.store(lanes);
    for (int i = 0; i < kDoubleParts; ++i)
      v[i] = hn::PromoteTo(DoubleTag(), hn::Load(half, lanes + i * kDoublePartWidth));
  }
  /// `p` is aligned to 64 bytes and has 16 elements.
  static TESSERA_INLINE Double load(const double* p) {
    return make([&](int i) { return hn::Load(DoubleTag(), p + i * kDoublePartWidth); });
  }
  TESSERA_INLINE void store(double* p) const {
    for (int i = 0; i < kDoubleParts; ++i) hn::Store(v[i], DoubleTag(), p + i * kDoublePartWidth);
  }
  /// Rounded to the nearest float.
  TESSERA_INLINE Float to_float() const {
    const hn::Rebind<float, DoubleTag> half;
    alignas(64) float lanes[kWidth];
    for (int i = 0; i < kDoubleParts; ++i)
      hn::Store(hn::DemoteTo(half, v[i]), half, lanes + i * kDoublePartWidth);
    return Float::load(lanes);
  }
  /// The Double whose part i is f(i).
  template <class F>
  static TESSERA_INLINE Double make(F&& f) {
    Double result;
    for (int i = 0; i < kDoubleParts; ++i) result.v[i] = f(i);
    return result;
  }
};

#define TESSERA_DOUBLE_BINARY(op, function)                                   \
  TESSERA_INLINE Double operator op(Double a, Double b) {                     \
    return Double::make([&](int i) { return hn::function(a.v[i], b.v[i]); }); \
  }
TESSERA_DOUBLE_BINARY(+, Add)
TESSERA_DOUBLE_BINARY(-, Sub)
TESSERA_DOUBLE_BINARY(*, Mul)
TESSERA_DOUBLE_BINARY(/, Div)
#undef TESSERA_DOUBLE_BINARY

#define TESSERA_DOUBLE_COMPARE(op, function)                                      \
  TESSERA_INLINE DoubleMask operator op(Double a, Double b) {                     \
    DoubleMask m;                                                                 \
    for (int i = 0; i < kDoubleParts; ++i) m.v[i] = hn::function(a.v[i], b.v[i]); \
    return m;                                                                     \
  }
TESSERA_DOUBLE_COMPARE(<, Lt)
TESSERA_DOUBLE_COMPARE(<=, Le)
TESSERA_DOUBLE_COMPARE(>, Gt)
TESSERA_DOUBLE_COMPARE(>=, Ge)
TESSERA_DOUBLE_COMPARE(==, Eq)
#undef TESSERA_DOUBLE_COMPARE

#define TESSERA_DOUBLE_MASK(op, function)                                         \
  TESSERA_INLINE DoubleMask operator op(DoubleMask a, DoubleMask b) {             \
    for (int i = 0; i < kDoubleParts; ++i) a.v[i] = hn::function(a.v[i], b.v[i]); \
    return a;                                                                     \
  }
TESSERA_DOUBLE_MASK(&, And)
TESSERA_DOUBLE_MASK(|, Or)
#undef TESSERA_DOUBLE_MASK

TESSERA_INLINE Mask mask_of(DoubleMask m) {
  std::uint32_t bits = 0;
  for (int i = 0; i < kDoubleParts; ++i) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(DoubleTag(), m.v[i], bytes);
    bits |= std::uint32_t{bytes[0]} << (i * kDoublePartWidth);
  }
  return Mask::from_bits(bits);
}
/// The same where a Real is a Float.
TESSERA_INLINE Mask mask_of(Mask m) { return m; }
TESSERA_INLINE DoubleMask double_mask_of(Mask m) {
  const Double one(select(m, Float(1.0f), Float(0.0f)));
  return one > Double(0.5);
}

/// mask ? a : b
TESSERA_INLINE Double select(DoubleMask m, Double a, Double b) {
  return Double::make([&](int i) { return hn::IfThenElse(m.v[i], a.v[i], b.v[i]); });
}
TESSERA_INLINE Double operator-(Double a) {
  return Double::make([&](int i) { return hn::Neg(a.v[i]); });
}
TESSERA_INLINE Double fma(Double a, Double b, Double c) {
  return Double::make([&](int i) { return hn::MulAdd(a.v[i], b.v[i], c.v[i]); });
}
TESSERA_INLINE Double min(Double a, Double b) {
  return Double::make([&](int i) { return hn::Min(a.v[i], b.v[i]); });
}
TESSERA_INLINE Double max(Double a, Double b) {
  return Double::make([&](int i) { return hn::Max(a.v[i], b.v[i]); });
}
#define TESSERA_DOUBLE_FUNCTION(name, function)                       \
  TESSERA_INLINE Double name(Double a) {                              \
    return Double::make([&](int i) { return hn::function(a.v[i]); }); \
  }
TESSERA_DOUBLE_FUNCTION(sqrt, Sqrt)
TESSERA_DOUBLE_FUNCTION(abs, Abs)
TESSERA_DOUBLE_FUNCTION(floor, Floor)
#undef TESSERA_DOUBLE_FUNCTION

// Arguments are finite: sine and cosine within 39000, exp up to 706, log above 0. Right to four units in the
// last place; sine and cosine, to 2^-50.
#define TESSERA_DOUBLE_TRANSCENDENTAL(name, function)                              \
  inline Double name(Double a) {                                                   \
    return Double::make([&](int i) { return hn::function(DoubleTag(), a.v[i]); }); \
  }
TESSERA_DOUBLE_TRANSCENDENTAL(exp, Exp)
TESSERA_DOUBLE_TRANSCENDENTAL(log, Log)
TESSERA_DOUBLE_TRANSCENDENTAL(sin, Sin)
TESSERA_DOUBLE_TRANSCENDENTAL(cos, Cos)
#undef TESSERA_DOUBLE_TRANSCENDENTAL

}  // namespace tessera::render::TESSERA_ISA
