// Active lanes behind one another, for all fields of a path or of a connection at once.
#pragma once

#include <array>
#include <cstdint>

#include "render/transport/vertex/path_state.h"

namespace tessera::render::TESSERA_ISA {

/// The places of 16 lanes of which the active ones are stored behind one another: told once, for all fields
/// of an entry.
class Packing {
 public:
  explicit TESSERA_INLINE Packing(Mask active) : active_(active) {
    if constexpr (kByTable) {
      std::uint32_t bits = active.bits();
      for_each_part([&](auto i) {
        const std::uint32_t part = bits & 0xffu;
        const auto lanes = hn::LoadU(hn::Rebind<std::uint8_t, Tag<std::int32_t>>(), kPacked[part].data());
        from_[i()] = hn::IndicesFromVec(Tag<float>(), hn::PromoteTo(Tag<std::int32_t>(), lanes));
        count_[i()] = __builtin_popcount(part);
        bits >>= 8;
      });
    }
  }

  /// `p` has room for 16: what is behind the active ones becomes anything.
  template <class T>
  TESSERA_INLINE void store(Wide<T> a, T* p) const {
    if constexpr (kByTable) {
      for_each_part([&](auto i) {
        const auto part = hn::BitCast(Tag<float>(), a.v[i()]);
        hn::StoreU(hn::BitCast(Tag<T>(), hn::TableLookupLanes(part, from_[i()])), Tag<T>(), p);
        p += count_[i()];
      });
    } else {
      compress_store(a, active_, p);
    }
  }

 private:
  /// AVX-512 has an instruction. For AVX2, lane by lane is faster than a look-up for one field, and slower
  /// than one for all.
  static constexpr bool kByTable = kPartWidth == 8;
  /// Indexed by the bits of 8 lanes: the active ones, then others.
  static constexpr auto kPacked = [] {
    std::array<std::array<std::uint8_t, 8>, 256> table{};
    for (std::size_t bits = 0; bits < table.size(); ++bits) {
      std::size_t n = 0;
      for (std::uint8_t lane = 0; lane < 8; ++lane) {
        if ((bits >> lane & 1) != 0) table[bits][n++] = lane;
      }
    }
    return table;
  }();
  using Indices = decltype(hn::IndicesFromVec(Tag<float>(), hn::Zero(Tag<std::int32_t>())));

  Mask active_;
  Indices from_[kParts];
  int count_[kParts];
};

/// append() where nothing is kept yet in the 16 entries from entry `at` on: what is behind the active ones
/// becomes anything.
template <template <class> class Fields>
TESSERA_INLINE int append_at_end(const SceneTables& scene, const Fields<Wide16>& from, Mask active,
                                 Fields<InMemory>& to, int at) {
  const Packing packing(active);
  Fields<InMemory>::for_each(
      scene,
      [&](const auto& field, auto& memory) {
        for_each_component([&](const auto& value, auto& lanes) { packing.store(value, &lanes[0] + at); },
                           field, memory);
      },
      from, to);
  return count(active);
}

}  // namespace tessera::render::TESSERA_ISA
