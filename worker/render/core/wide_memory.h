// Wide values and memory: gathering, scattering, packing, and lanes one by one. The second half of wide.h,
// which includes it. Guarded like that file, for the same reason.
#ifndef TESSERA_RENDER_CORE_WIDE_MEMORY_H
#define TESSERA_RENDER_CORE_WIDE_MEMORY_H

#include "render/core/wide.h"

namespace tessera::render::TESSERA_ISA {

/// Every index is valid. Sixteen loads: with the microcode against data sampling, the gather instruction
/// takes 1.5 (AVX-512) to 2.5 times as long (AVX2) [docs/decisions/0001-simd-library.md].
template <class T>
TESSERA_INLINE Wide<T> gather(const T* base, Int index) {
  alignas(64) std::int32_t at[kWidth];
  index.store(at);
  alignas(64) T lanes[kWidth];
  for (int i = 0; i < kWidth; ++i) lanes[i] = base[at[i]];
  return Wide<T>::load(lanes);
}
/// base[index[i]] for active lanes, else 0. `base` has at least one element.
template <class T>
TESSERA_INLINE Wide<T> gather(const T* base, Int index, Mask active) {
  return select_or_zero(active, gather(base, select_or_zero(active, index)));
}
/// The 4-byte member `member` of records[index[i]] for active lanes, else 0.
template <class Record, class T>
TESSERA_INLINE Wide<T> gather_member(const Record* records, T Record::*member, Int index, Mask active) {
  static_assert(sizeof(Record) % 4 == 0 && sizeof(T) == 4);
  return gather(&(records->*member), index * static_cast<std::int32_t>(sizeof(Record) / 4), active);
}

/// Four Wides at once.
template <class T>
struct Wide4 {
  Wide<T> c[4];
};
using Float4 = Wide4<float>;
using Int4 = Wide4<std::int32_t>;

namespace detail {
/// The four numbers at base + at(0), base + at(4), ... side by side in one native vector. Blending rows as
/// they are loaded leaves the port free that inserting needs (AVX-512: 8 ns for all of gather4, not 13).
template <class T, class At>
TESSERA_INLINE auto load_blocks(const T* base, At at) {
  const Tag<T> d;
  if constexpr (kPartWidth == 16) {
    const auto block = [&](int k) { return hn::LoadDup128(d, base + at(4 * k)); };
    auto blocks = hn::IfThenElse(hn::FirstN(d, 12), block(2), block(3));
    blocks = hn::IfThenElse(hn::FirstN(d, 8), block(1), blocks);
    return hn::IfThenElse(hn::FirstN(d, 4), block(0), blocks);
  } else if constexpr (kPartWidth == 8) {
    const hn::CappedTag<T, 4> half;
    return hn::Combine(d, hn::LoadU(half, base + at(4)), hn::LoadU(half, base + at(0)));
  } else {
    return hn::LoadU(d, base + at(0));
  }
}

/// Indices on their way to the integer registers, two at a time.
class IndexPairs {
 public:
  explicit TESSERA_INLINE IndexPairs(Int index) { index.store(reinterpret_cast<std::int32_t*>(pairs_)); }
  /// They are not negative.
  TESSERA_INLINE std::size_t operator[](int i) const {
    return i % 2 == 0 ? pairs_[i / 2] & 0xffffffffu : pairs_[i / 2] >> 32;
  }

 private:
  alignas(64) std::uint64_t pairs_[kWidth / 2];
};
}  // namespace detail

/// base[index[i]] .. base[index[i] + 3] for every lane, transposed: one load a lane instead of four. Lanes
/// that are not active read base[0] .. base[3], which must be there, and give anything.
template <class T>
TESSERA_INLINE Wide4<T> gather4(const T* base, Int index, Mask active) {
  const detail::IndexPairs at(select_or_zero(active, index));
  Wide4<T> result;
  for_each_part([&](auto part) __attribute__((always_inline)) {
    constexpr int kFirst = static_cast<int>(part()) * kPartWidth;
    const Tag<T> d;
    const hn::Repartition<std::uint64_t, Tag<T>> d64;
    // Lane k of each block of four is row k: a 4 x 4 transpose in every block.
    const auto row = [&](int k) {
      return detail::load_blocks(base, [&](int i) { return at[kFirst + k + i]; });
    };
    const auto a = row(0), b = row(1);
    const auto e = row(2), f = row(3);
    const auto ab_low = hn::BitCast(d64, hn::InterleaveLower(d, a, b)),
               ab_high = hn::BitCast(d64, hn::InterleaveUpper(d, a, b));
    const auto ef_low = hn::BitCast(d64, hn::InterleaveLower(d, e, f)),
               ef_high = hn::BitCast(d64, hn::InterleaveUpper(d, e, f));
    result.c[0].v[part()] = hn::BitCast(d, hn::InterleaveLower(d64, ab_low, ef_low));
    result.c[1].v[part()] = hn::BitCast(d, hn::InterleaveUpper(d64, ab_low, ef_low));
    result.c[2].v[part()] = hn::BitCast(d, hn::InterleaveLower(d64, ab_high, ef_high));
    result.c[3].v[part()] = hn::BitCast(d, hn::InterleaveUpper(d64, ab_high, ef_high));
  });
  return result;
}

/// Writes the active lanes one after the other; returns how many. `p` has room for 16.
template <class T>
TESSERA_INLINE int compress_store(Wide<T> a, Mask active, T* p) {
  if constexpr (kParts > 1) {
    // No instruction for it below AVX-512: lane by lane is 3.5 times faster than shuffling by table.
    alignas(64) T lanes[kWidth];
    a.store(lanes);
    int n = 0;
    for (std::uint32_t bits = active.bits(); bits != 0; bits &= bits - 1) p[n++] = lanes[__builtin_ctz(bits)];
    return n;
  }
  std::size_t written = 0;
  for_each_part([&](auto i) {
    written +=
        hn::CompressBlendedStore(a.v[i()], hn::RebindMask(Tag<T>(), active.v[i()]), Tag<T>(), p + written);
  });
  return static_cast<int>(written);
}
/// base[index[i]] = a[i] for active lanes; indices of active lanes are distinct.
template <class T>
TESSERA_INLINE void scatter(Wide<T> a, T* base, Int index, Mask active) {
  alignas(64) T values[kWidth];
  alignas(64) std::int32_t indices[kWidth];
  a.store(values);
  index.store(indices);
  for (std::uint32_t bits = active.bits(); bits != 0; bits &= bits - 1) {
    const int i = __builtin_ctz(bits);
    base[indices[i]] = values[i];
  }
}

/// Calls f(key, lanes) once for every distinct value of `keys` among the active lanes.
template <class F>
TESSERA_INLINE void for_each_distinct(Int keys, Mask active, F&& f) {
  alignas(64) std::int32_t lanes[kWidth];
  keys.store(lanes);
  std::uint32_t left = active.bits();
  while (left != 0) {
    const std::int32_t key = lanes[__builtin_ctz(left)];
    const Mask same = active & (keys == key);
    f(key, same);
    left &= ~same.bits();
  }
}

/// The value that all active lanes share; none where they differ, or there are none.
TESSERA_INLINE std::optional<std::int32_t> common_value(Int a, Mask active) {
  const std::uint32_t bits = active.bits();
  if (bits == 0) return std::nullopt;
  const std::int32_t first = a.lane(__builtin_ctz(bits));
  if (any(active & (a != first))) return std::nullopt;
  return first;
}

/// The largest lane.
TESSERA_INLINE float reduce_max(Float a) {
  alignas(64) float lanes[kWidth];
  a.store(lanes);
  float result = lanes[0];
  for (int i = 1; i < kWidth; ++i) result = lanes[i] > result ? lanes[i] : result;
  return result;
}

}  // namespace tessera::render::TESSERA_ISA

#endif  // TESSERA_RENDER_CORE_WIDE_MEMORY_H
