// A batch of paths in memory: structures of arrays, so that 16 of them load as one wide value.
#pragma once

#include <cstdint>
#include <type_traits>

#include "render/accel/ray_query.h"
#include "render/color/spectra.h"
#include "render/core/vec.h"

namespace tessera::render::TESSERA_ISA {

/// Paths a thread has in flight. Measured: 512 to 2k is best, 16k costs 5-12 % (docs/architecture.md).
inline constexpr int kBatch = 1024;
/// Room for a full wide store at any position.
inline constexpr int kPadded = kBatch + kWidth;

template <class T>
using Lanes = T[kPadded];
// So that one after the other is aligned.
static_assert(sizeof(Lanes<float>) % 64 == 0);

struct alignas(64) Vec3Lanes {
  Lanes<float> x, y, z;
};

struct alignas(64) SpectrumLanes {
  Lanes<float> c[kSpectrumLanes];
};
using WavelengthLanes = std::conditional_t<kSpectral, SpectrumLanes, Wavelengths>;

/// How the fields of a path are held: 16 of each in registers, or a batch of each in memory.
struct Wide16 {
  using Scalar = Float;
  using Integer = Int;
  using Vector = Vec3;
  using Colour = Spectrum;
  using Wavelengths = TESSERA_ISA::Wavelengths;
};
struct InMemory {
  using Scalar = Lanes<float>;
  using Integer = Lanes<std::int32_t>;
  using Vector = Vec3Lanes;
  using Colour = SpectrumLanes;
  using Wavelengths = WavelengthLanes;
};

/// Calls f(component of the first, of the second, ...) for each component of a field in all of these forms.
template <class F, class First, class... Rest>
TESSERA_INLINE void for_each_component(F&& f, First&& first, Rest&&... rest) {
  if constexpr (requires { first.x; }) {
    f(first.x, rest.x...);
    f(first.y, rest.y...);
    f(first.z, rest.z...);
  } else if constexpr (requires { first.c; }) {
    for (int k = 0; k < kSpectrumLanes; ++k) f(first.c[k], rest.c[k]...);
  } else if constexpr (!std::is_empty_v<std::remove_cvref_t<First>>) {
    f(first, rest...);
  }
}

// A field's 16 entries from entry i on, or at `index`; the active ones stored there, or behind one another.
template <class T, class Memory>
TESSERA_INLINE void load_lanes(const Memory& from, int i, T& value) {
  for_each_component(
      [&](auto& to, const auto& lanes) { to = std::decay_t<decltype(to)>::load(&lanes[0] + i); }, value,
      from);
}
template <class T, class Memory>
TESSERA_INLINE void store_lanes(const T& value, Memory& to, int i) {
  for_each_component([&](const auto& from, auto& lanes) { from.store(&lanes[0] + i); }, value, to);
}
template <class T, class Memory>
TESSERA_INLINE T gather_lanes(const Memory& from, Int index, Mask active) {
  T value;
  for_each_component([&](auto& to, const auto& lanes) { to = gather(&lanes[0], index, active); }, value,
                     from);
  return value;
}
template <class T, class Memory>
TESSERA_INLINE void scatter_lanes(const T& value, Memory& to, Int index, Mask active) {
  for_each_component([&](const auto& from, auto& lanes) { scatter(from, &lanes[0], index, active); }, value,
                     to);
}
template <class T, class Memory>
TESSERA_INLINE void append_lanes(const T& value, Mask active, Memory& to, int i) {
  for_each_component([&](const auto& from, auto& lanes) { compress_store(from, active, &lanes[0] + i); },
                     value, to);
}
/// 16 entries at `index` become those from entry i on.
template <class Memory>
TESSERA_INLINE void copy_lanes(const Memory& from, Int index, Memory& to, int i) {
  for_each_component([&](const auto& source, auto& lanes) { gather(&source[0], index).store(&lanes[0] + i); },
                     from, to);
}
/// In the active lanes; the others become anything.
template <class Memory>
TESSERA_INLINE void copy_lanes(const Memory& from, Int index, Mask active, Memory& to, int i) {
  for_each_component(
      [&](const auto& source, auto& lanes) { gather(&source[0], index, active).store(&lanes[0] + i); }, from,
      to);
}

/// Hits of rays, entry by entry.
template <class Form>
struct alignas(64) HitFields {
  typename Form::Scalar t, u, v;
  typename Form::Integer primitive, shape, instance;
  typename Form::Integer upper = {};  // scenes with objects within objects only

  template <class F, class... Hits>
  static TESSERA_INLINE void for_each(F&& f, Hits&... hits) {
    f(hits.t...), f(hits.u...), f(hits.v...);
    f(hits.primitive...), f(hits.shape...), f(hits.instance...), f(hits.upper...);
  }
};
struct HitState : HitFields<InMemory> {
  /// The arrays for a query to fill.
  HitArrays arrays() { return {t, u, v, primitive, shape, instance, nullptr, upper}; }
};

/// The arrays for a query to read.
inline RayArrays arrays_of(const Vec3Lanes& origin, const Vec3Lanes& direction, const float* times) {
  return {origin.x, origin.y, origin.z, direction.x, direction.y, direction.z, times};
}

}  // namespace tessera::render::TESSERA_ISA
