// SPMD vectors: one C++ value for 16 lanes. The only file that knows how wide the machine is.
//
// Everything in namespace tessera::render::TESSERA_ISA is compiled once for every kernel ISA ("avx2",
// "avx512", "neon"), with that ISA's compiler flags, into a library of its own that is chosen at start-up. A
// Wide<T> is as many native vectors as make 16 lanes: one on AVX-512, two on AVX2, four on NEON. Built on
// Google Highway [docs/decisions/0001-simd-library.md].
//
// No approximate reciprocals or roots: their bits differ between CPU makers.
// No #pragma once here: this file is precompiled, and what a compiler cache brings back was made when the
// file was of another age, which GCC takes for another file.
#ifndef TESSERA_RENDER_CORE_WIDE_H
#define TESSERA_RENDER_CORE_WIDE_H

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include <cstdint>
#include <optional>
#include <type_traits>
#include <utility>

#ifndef TESSERA_ISA
#error \
    "kernel headers are for kernel libraries only (tessera_kernel_library in deploy/cmake/TesseraTargets.cmake)"
#endif

namespace tessera::render::TESSERA_ISA {

namespace hn = hwy::HWY_NAMESPACE;

inline constexpr int kWidth = 16;

/// Tag, native vector and number of native vectors for lanes of type T (4 bytes each).
template <class T>
using Tag = hn::CappedTag<T, kWidth>;
template <class T>
using Native = hn::Vec<Tag<T>>;
inline constexpr int kPartWidth = static_cast<int>(hn::MaxLanes(Tag<float>()));
inline constexpr int kParts = kWidth / kPartWidth;
static_assert(kPartWidth * kParts == kWidth);

#define TESSERA_INLINE inline __attribute__((always_inline))

namespace detail {
using Indices = std::make_index_sequence<kParts>;

template <class Result, class F, std::size_t... I>
TESSERA_INLINE Result make(F&& f, std::index_sequence<I...>) {
  return Result{{f(std::integral_constant<std::size_t, I>{})...}};
}
template <class F, std::size_t... I>
TESSERA_INLINE void each(F&& f, std::index_sequence<I...>) {
  (f(std::integral_constant<std::size_t, I>{}), ...);
}
}  // namespace detail

/// A Result whose part i is f(i).
template <class Result, class F>
TESSERA_INLINE Result make_parts(F&& f) {
  return detail::make<Result>(f, detail::Indices{});
}
template <class F>
TESSERA_INLINE void for_each_part(F&& f) {
  detail::each(f, detail::Indices{});
}

// ---------------------------------------------------------------- masks

/// One bit a lane.
struct Mask {
  using Part = hn::Mask<Tag<float>>;
  Part v[kParts];

  static TESSERA_INLINE Mask none() {
    return make_parts<Mask>([](auto) { return hn::MaskFromVec(hn::Zero(Tag<float>())); });
  }
  static TESSERA_INLINE Mask all() { return first(kWidth); }
  /// Lanes 0 .. n-1.
  static TESSERA_INLINE Mask first(int n) {
    return make_parts<Mask>([n](auto i) {
      const int m = n - static_cast<int>(i()) * kPartWidth;
      return hn::FirstN(Tag<float>(), static_cast<std::size_t>(m < 0 ? 0 : m));
    });
  }
  /// Bit i of `bits` is lane i.
  static TESSERA_INLINE Mask from_bits(std::uint32_t bits) {
    return make_parts<Mask>([bits](auto i) {
      const Tag<std::uint32_t> d;
      const auto lane = hn::Add(hn::Iota(d, 0u), hn::Set(d, static_cast<std::uint32_t>(i() * kPartWidth)));
      const auto bit = hn::And(hn::Shr(hn::Set(d, bits), lane), hn::Set(d, 1u));
      return hn::RebindMask(Tag<float>(), hn::Ne(bit, hn::Zero(d)));
    });
  }
  TESSERA_INLINE std::uint32_t bits() const {
    std::uint32_t result = 0;
    for_each_part([&](auto i) {
      std::uint8_t bytes[8] = {};
      hn::StoreMaskBits(Tag<float>(), v[i()], bytes);
      const std::uint32_t part = bytes[0] | (kPartWidth > 8 ? std::uint32_t{bytes[1]} << 8 : 0u);
      result |= part << (i() * kPartWidth);
    });
    return result;
  }
};

TESSERA_INLINE Mask operator&(Mask a, Mask b) {
  return make_parts<Mask>([&](auto i) { return hn::And(a.v[i()], b.v[i()]); });
}
TESSERA_INLINE Mask operator|(Mask a, Mask b) {
  return make_parts<Mask>([&](auto i) { return hn::Or(a.v[i()], b.v[i()]); });
}
TESSERA_INLINE Mask operator^(Mask a, Mask b) {
  return make_parts<Mask>([&](auto i) { return hn::Xor(a.v[i()], b.v[i()]); });
}
TESSERA_INLINE Mask operator~(Mask a) {
  return make_parts<Mask>([&](auto i) { return hn::Not(a.v[i()]); });
}
/// a and not b
TESSERA_INLINE Mask and_not(Mask a, Mask b) {
  return make_parts<Mask>([&](auto i) { return hn::AndNot(b.v[i()], a.v[i()]); });
}
TESSERA_INLINE Mask& operator&=(Mask& a, Mask b) { return a = a & b; }
TESSERA_INLINE Mask& operator|=(Mask& a, Mask b) { return a = a | b; }

TESSERA_INLINE bool none(Mask m) {
  bool result = true;
  for_each_part([&](auto i) { result = result && hn::AllFalse(Tag<float>(), m.v[i()]); });
  return result;
}
TESSERA_INLINE bool any(Mask m) { return !none(m); }
TESSERA_INLINE bool all(Mask m) {
  bool result = true;
  for_each_part([&](auto i) { result = result && hn::AllTrue(Tag<float>(), m.v[i()]); });
  return result;
}
TESSERA_INLINE int count(Mask m) {
  std::size_t result = 0;
  for_each_part([&](auto i) { result += hn::CountTrue(Tag<float>(), m.v[i()]); });
  return static_cast<int>(result);
}

// ---------------------------------------------------------------- numbers

/// Sixteen numbers of type float, int32_t or uint32_t.
template <class T>
struct Wide {
  Native<T> v[kParts];

  Wide() = default;
  TESSERA_INLINE Wide(T x) {
    for_each_part([&](auto i) { v[i()] = hn::Set(Tag<T>(), x); });
  }
  /// One native vector a part.
  template <class... P>
  requires(sizeof...(P) == kParts && (std::is_same_v<P, Native<T>> && ...)) TESSERA_INLINE
      explicit Wide(P... parts)
      : v{parts...} {}

  /// `p` is aligned to 64 bytes and has 16 elements.
  static TESSERA_INLINE Wide load(const T* p) {
    return make([&](auto i) { return hn::Load(Tag<T>(), p + i() * kPartWidth); });
  }
  static TESSERA_INLINE Wide load_unaligned(const T* p) {
    return make([&](auto i) { return hn::LoadU(Tag<T>(), p + i() * kPartWidth); });
  }
  TESSERA_INLINE void store(T* p) const {
    for_each_part([&](auto i) { hn::Store(v[i()], Tag<T>(), p + i() * kPartWidth); });
  }
  TESSERA_INLINE void store_unaligned(T* p) const {
    for_each_part([&](auto i) { hn::StoreU(v[i()], Tag<T>(), p + i() * kPartWidth); });
  }
  /// 0, 1, 2, ... 15, plus `start`.
  static TESSERA_INLINE Wide iota(T start = 0) {
    return make([&](auto i) { return hn::Iota(Tag<T>(), start + static_cast<T>(i() * kPartWidth)); });
  }
  TESSERA_INLINE T lane(int i) const {
    alignas(64) T lanes[kWidth];
    store(lanes);
    return lanes[i];
  }

  /// The Wide whose part i is f(i).
  template <class F>
  static TESSERA_INLINE Wide make(F&& f) {
    Wide result;
    for_each_part([&](auto i) { result.v[i()] = f(i); });
    return result;
  }
};

using Float = Wide<float>;
using Int = Wide<std::int32_t>;
using UInt = Wide<std::uint32_t>;

#define TESSERA_WIDE_BINARY(op, function)                                           \
  template <class T>                                                                \
  TESSERA_INLINE Wide<T> operator op(Wide<T> a, Wide<T> b) {                        \
    return Wide<T>::make([&](auto i) { return hn::function(a.v[i()], b.v[i()]); }); \
  }                                                                                 \
  template <class T>                                                                \
  TESSERA_INLINE Wide<T> operator op(Wide<T> a, std::type_identity_t<T> b) {        \
    return a op Wide<T>(b);                                                         \
  }                                                                                 \
  template <class T>                                                                \
  TESSERA_INLINE Wide<T> operator op(std::type_identity_t<T> a, Wide<T> b) {        \
    return Wide<T>(a) op b;                                                         \
  }                                                                                 \
  template <class T, class U>                                                       \
  TESSERA_INLINE Wide<T>& operator op##=(Wide<T>& a, U b) {                         \
    return a = a op b;                                                              \
  }
TESSERA_WIDE_BINARY(+, Add)
TESSERA_WIDE_BINARY(-, Sub)
TESSERA_WIDE_BINARY(*, Mul)
TESSERA_WIDE_BINARY(/, Div)
TESSERA_WIDE_BINARY(&, And)
TESSERA_WIDE_BINARY(|, Or)
TESSERA_WIDE_BINARY(^, Xor)
#undef TESSERA_WIDE_BINARY

namespace detail {
// Highway orders integers by < and > only.
template <class V>
TESSERA_INLINE auto less_equal(V a, V b) {
  if constexpr (std::is_floating_point_v<hn::TFromV<V>>) {
    return hn::Le(a, b);
  } else {
    return hn::Not(hn::Gt(a, b));
  }
}
template <class V>
TESSERA_INLINE auto greater_equal(V a, V b) {
  return less_equal(b, a);
}
}  // namespace detail

#define TESSERA_WIDE_COMPARE(op, function)                                                   \
  template <class T>                                                                         \
  TESSERA_INLINE Mask operator op(Wide<T> a, Wide<T> b) {                                    \
    return make_parts<Mask>(                                                                 \
        [&](auto i) { return hn::RebindMask(Tag<float>(), function(a.v[i()], b.v[i()])); }); \
  }                                                                                          \
  template <class T>                                                                         \
  TESSERA_INLINE Mask operator op(Wide<T> a, std::type_identity_t<T> b) {                    \
    return a op Wide<T>(b);                                                                  \
  }                                                                                          \
  template <class T>                                                                         \
  TESSERA_INLINE Mask operator op(std::type_identity_t<T> a, Wide<T> b) {                    \
    return Wide<T>(a) op b;                                                                  \
  }
TESSERA_WIDE_COMPARE(==, hn::Eq)
TESSERA_WIDE_COMPARE(!=, hn::Ne)
TESSERA_WIDE_COMPARE(<, hn::Lt)
TESSERA_WIDE_COMPARE(<=, detail::less_equal)
TESSERA_WIDE_COMPARE(>, hn::Gt)
TESSERA_WIDE_COMPARE(>=, detail::greater_equal)
#undef TESSERA_WIDE_COMPARE

template <class T>
TESSERA_INLINE Wide<T> operator-(Wide<T> a) {
  return Wide<T>::make([&](auto i) { return hn::Neg(a.v[i()]); });
}

/// The same shift for all lanes.
template <int kBits, class T>
TESSERA_INLINE Wide<T> shift_left(Wide<T> a) {
  return Wide<T>::make([&](auto i) { return hn::ShiftLeft<kBits>(a.v[i()]); });
}
template <int kBits, class T>
TESSERA_INLINE Wide<T> shift_right(Wide<T> a) {
  return Wide<T>::make([&](auto i) { return hn::ShiftRight<kBits>(a.v[i()]); });
}

/// mask ? a : b
template <class T>
TESSERA_INLINE Wide<T> select(Mask mask, Wide<T> a, Wide<T> b) {
  return Wide<T>::make(
      [&](auto i) { return hn::IfThenElse(hn::RebindMask(Tag<T>(), mask.v[i()]), a.v[i()], b.v[i()]); });
}
template <class T>
TESSERA_INLINE Wide<T> select(Mask mask, Wide<T> a, std::type_identity_t<T> b) {
  return select(mask, a, Wide<T>(b));
}
template <class T>
TESSERA_INLINE Wide<T> select(Mask mask, std::type_identity_t<T> a, Wide<T> b) {
  return select(mask, Wide<T>(a), b);
}
/// mask ? a : 0
template <class T>
TESSERA_INLINE Wide<T> select_or_zero(Mask mask, Wide<T> a) {
  return Wide<T>::make(
      [&](auto i) { return hn::IfThenElseZero(hn::RebindMask(Tag<T>(), mask.v[i()]), a.v[i()]); });
}

#define TESSERA_WIDE_FUNCTION1(name, function)                          \
  TESSERA_INLINE Float name(Float a) {                                  \
    return Float::make([&](auto i) { return hn::function(a.v[i()]); }); \
  }
TESSERA_WIDE_FUNCTION1(sqrt, Sqrt)
TESSERA_WIDE_FUNCTION1(floor, Floor)
TESSERA_WIDE_FUNCTION1(abs, Abs)
#undef TESSERA_WIDE_FUNCTION1

template <class T>
TESSERA_INLINE Wide<T> min(Wide<T> a, Wide<T> b) {
  return Wide<T>::make([&](auto i) { return hn::Min(a.v[i()], b.v[i()]); });
}
template <class T>
TESSERA_INLINE Wide<T> min(Wide<T> a, std::type_identity_t<T> b) {
  return min(a, Wide<T>(b));
}
template <class T>
TESSERA_INLINE Wide<T> max(Wide<T> a, Wide<T> b) {
  return Wide<T>::make([&](auto i) { return hn::Max(a.v[i()], b.v[i()]); });
}
template <class T>
TESSERA_INLINE Wide<T> max(Wide<T> a, std::type_identity_t<T> b) {
  return max(a, Wide<T>(b));
}
template <class T>
TESSERA_INLINE Wide<T> clamp(Wide<T> a, std::type_identity_t<T> low, std::type_identity_t<T> high) {
  return min(max(a, low), high);
}
/// a * b + c in one rounding
TESSERA_INLINE Float fma(Float a, Float b, Float c) {
  return Float::make([&](auto i) { return hn::MulAdd(a.v[i()], b.v[i()], c.v[i()]); });
}
/// c - a * b in one rounding
TESSERA_INLINE Float fnma(Float a, Float b, Float c) {
  return Float::make([&](auto i) { return hn::NegMulAdd(a.v[i()], b.v[i()], c.v[i()]); });
}
TESSERA_INLINE Float sqr(Float a) { return a * a; }
TESSERA_INLINE Float safe_sqrt(Float a) { return sqrt(max(a, 0.0f)); }
/// |a| with the sign of b
TESSERA_INLINE Float copysign(Float a, Float b) {
  return Float::make([&](auto i) { return hn::CopySign(a.v[i()], b.v[i()]); });
}
/// a * b - c * d without catastrophic cancellation [Kahan]
TESSERA_INLINE Float difference_of_products(Float a, Float b, Float c, Float d) {
  const Float cd = c * d;
  return fma(a, b, -cd) + fnma(c, d, cd);
}
TESSERA_INLINE Float lerp(Float t, Float a, Float b) { return fma(t, b - a, a); }

#define TESSERA_WIDE_MATH(name, function)                                             \
  TESSERA_INLINE Float name(Float a) {                                                \
    return Float::make([&](auto i) { return hn::function(Tag<float>(), a.v[i()]); }); \
  }
TESSERA_WIDE_MATH(exp, Exp)
TESSERA_WIDE_MATH(log, Log)
TESSERA_WIDE_MATH(sin, Sin)  // |a| <= 39000
TESSERA_WIDE_MATH(cos, Cos)  // |a| <= 39000
TESSERA_WIDE_MATH(acos, Acos)
TESSERA_WIDE_MATH(asin, Asin)
TESSERA_WIDE_MATH(atan, Atan)
#undef TESSERA_WIDE_MATH

// ---------------------------------------------------------------- conversion

/// Rounds towards zero.
TESSERA_INLINE Int to_int(Float a) {
  return Int::make([&](auto i) { return hn::ConvertTo(Tag<std::int32_t>(), a.v[i()]); });
}
TESSERA_INLINE Float to_float(Int a) {
  return Float::make([&](auto i) { return hn::ConvertTo(Tag<float>(), a.v[i()]); });
}
template <class To, class From>
TESSERA_INLINE Wide<To> bit_cast(Wide<From> a) {
  return Wide<To>::make([&](auto i) { return hn::BitCast(Tag<To>(), a.v[i()]); });
}
/// The upper 24 bits as a number in [0, 1).
TESSERA_INLINE Float to_unit_float(UInt bits) {
  return to_float(bit_cast<std::int32_t>(shift_right<8>(bits))) * 0x1p-24f;
}
TESSERA_INLINE Mask is_finite(Float a) { return abs(a) <= 3.402823466e38f; }

/// Angle of (x, y) in (-pi, pi]; 0 for (0, 0).
TESSERA_INLINE Float atan2(Float y, Float x) {
  const Float ax = abs(x), ay = abs(y);
  const Float high = max(ax, ay), low = min(ax, ay);
  Float angle = atan(low / select(high == 0.0f, 1.0f, high));
  angle = select(ay > ax, 1.57079632679f - angle, angle);
  angle = select(x < 0.0f, 3.14159265359f - angle, angle);
  return copysign(angle, y);
}
/// base^exponent for base >= 0
TESSERA_INLINE Float pow(Float base, Float exponent) {
  return select(base <= 0.0f, 0.0f, exp(exponent * log(max(base, 1e-38f))));
}

namespace detail {
alignas(16) inline constexpr std::uint8_t kReversedNibbles[16] = {0, 8, 4, 12, 2, 10, 6, 14,
                                                                  1, 9, 5, 13, 3, 11, 7, 15};
alignas(16) inline constexpr std::uint8_t kReversedBytes[16] = {3,  2,  1, 0, 7,  6,  5,  4,
                                                                11, 10, 9, 8, 15, 14, 13, 12};
}  // namespace detail

/// Bit 0 becomes bit 31 and so on: nibbles by table, then the order of the bytes.
TESSERA_INLINE UInt reverse_bits(UInt a) {
  return UInt::make([&](auto i) {
    const Tag<std::uint32_t> d;
    const hn::Repartition<std::uint8_t, Tag<std::uint32_t>> d8;
    const auto low_bits = hn::Set(d, 0x0f0f0f0fu);
    const auto low = hn::BitCast(d8, hn::And(a.v[i()], low_bits));
    const auto high = hn::BitCast(d8, hn::And(hn::ShiftRight<4>(a.v[i()]), low_bits));
    const auto table = hn::LoadDup128(d8, detail::kReversedNibbles);
    const auto swapped_low = hn::BitCast(d, hn::TableLookupBytes(table, low));
    const auto swapped =
        hn::Or(hn::ShiftLeft<4>(swapped_low), hn::BitCast(d, hn::TableLookupBytes(table, high)));
    return hn::BitCast(
        d, hn::TableLookupBytes(hn::BitCast(d8, swapped), hn::LoadDup128(d8, detail::kReversedBytes)));
  });
}

}  // namespace tessera::render::TESSERA_ISA

#include "render/core/wide_memory.h"

#endif  // TESSERA_RENDER_CORE_WIDE_H
