// Photons where they were caught, in a structure for all that lie within a radius of a place [Jensen 1996].
//
// The contents of a photon are up to the algorithm: a struct of fields in the manner of path_state.h, of
// which the map asks a `position`. One thread fills and builds a map; any number of them read it then. Order
// of photons, and with it every sum over them, follows from the order in which they were appended.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "render/core/big_array.h"
#include "render/transport/photon_map/cell_table.h"
#include "render/transport/vertex/lanes.h"

namespace tessera::render::TESSERA_ISA {

/// Fields of any number of photons in memory, a column each.
struct InColumns {
  using Scalar = BigArray<float>;
  using Integer = BigArray<std::int32_t>;
  struct Vector {
    Scalar x, y, z;
  };
  struct Colour {
    Scalar c[kSpectrumLanes];
  };
};

/// `Fields<Form>` has a Form::Vector named `position` and, like PathFields, lists all fields in
/// for_each(f, photons...).
template <template <class> class Fields>
class PhotonMap {
 public:
  using Wide = Fields<Wide16>;

  std::int32_t size() const { return size_; }
  /// Bytes of `photons` of them, while they are sorted.
  static std::size_t memory_bytes(std::size_t photons);

  void clear() { size_ = 0; }
  /// Keeps the active ones whose position is finite. Below 2^31 - 16 of them in all.
  void append(const Wide& photons, Mask active);
  /// Keeps those of the appended for which keep(entries), given the numbers of 16, answers with their
  /// lanes.
  template <class Keep>
  void filter(Keep&& keep);
  /// Sorts them for queries of `radius`, finite and not negative. Nothing is appended or filtered any more,
  /// until clear().
  void build(float radius);

  /// Calls visit(first, near, distance2) with 16 neighbours in memory, load(first), of which the lanes
  /// `near` lie closer to the place than the radius, with the squares of their distances. Every such photon
  /// is met once.
  template <class Visit>
  TESSERA_INLINE void for_each_near(float x, float y, float z, Visit&& visit) const;
  /// The photons from entry `first` on.
  TESSERA_INLINE Wide load(std::int32_t first) const;

  /// The photons at 16 entries.
  TESSERA_INLINE Wide gather(Int entries) const;

  /// For 16 places at once: calls visit(photons, near) with one photon a lane, near the place of that lane
  /// where `near` is set, until every place has met all of its own. For visitors that do much with each.
  template <class Visit>
  void for_each_near(Vec3 places, Mask active, Visit&& visit) const;

 private:
  template <class F, class... Photons>
  static void for_each_column(F&& f, Photons&... photons) {
    Fields<InColumns>::for_each([&](auto&... field) { for_each_component(f, field...); }, photons...);
  }
  void reserve(std::size_t photons);
  /// Squares of the distances of 16 neighbours in memory from a place.
  TESSERA_INLINE Float distance2(std::int32_t first, float x, float y, float z) const;
  struct Query;

  Fields<InColumns> photons_;  // room beyond the last for 16
  std::int32_t size_ = 0;
  float radius2_ = 0;
  CellTable cells_;
  // Memory of build()
  BigArray<std::int32_t> place_;
  BigArray<float> sorted_scalars_;
  BigArray<std::int32_t> sorted_integers_;
};

template <template <class> class Fields>
std::size_t PhotonMap<Fields>::memory_bytes(std::size_t photons) {
  std::size_t columns = 0;
  Fields<InColumns> none;
  for_each_column([&](auto&) { ++columns; }, none);
  // A column of scalars and one of integers to sort into, places, and the table of cells.
  return 4 * photons * (columns + 6);
}

template <template <class> class Fields>
void PhotonMap<Fields>::reserve(std::size_t photons) {
  const std::size_t needed = photons + kWidth;
  if (photons_.position.x.size() >= needed) return;
  const std::size_t room = std::max<std::size_t>(needed + needed / 2, kPadded);
  for_each_column([&](auto& column) { column.resize(room); }, photons_);
}

template <template <class> class Fields>
void PhotonMap<Fields>::append(const Wide& photons, Mask active) {
  const Vec3 p = photons.position;
  const Mask kept = active & is_finite(p.x) & is_finite(p.y) & is_finite(p.z);
  const int more = count(kept);
  if (more == 0) return;
  reserve(static_cast<std::size_t>(size_) + kWidth);
  Fields<InColumns>::for_each(
      [&](const auto& field, auto& columns) { append_lanes(field, kept, columns, size_); }, photons,
      photons_);
  size_ += more;
}

template <template <class> class Fields>
template <class Keep>
void PhotonMap<Fields>::filter(Keep&& keep) {
  int kept = 0;
  for (std::int32_t i = 0; i < size_; i += kWidth) {
    const Wide photons = load(i);
    const Mask stays = Mask::first(size_ - i) & keep(Int::iota(i));
    Fields<InColumns>::for_each(
        [&](const auto& field, auto& columns) { append_lanes(field, stays, columns, kept); }, photons,
        photons_);
    kept += count(stays);
  }
  size_ = kept;
}

template <template <class> class Fields>
void PhotonMap<Fields>::build(float radius) {
  const auto size = static_cast<std::size_t>(size_);
  const auto column = [&](const BigArray<float>& all) { return std::span(all).first(size); };
  cells_.build(column(photons_.position.x), column(photons_.position.y), column(photons_.position.z), radius,
               place_);
  radius2_ = radius * radius;
  const auto sort = [&]<class T>(BigArray<T>& from, BigArray<T>& sorted) {
    sorted.resize(from.size());
    for (std::size_t i = 0; i < size; ++i) sorted[static_cast<std::size_t>(place_[i])] = from[i];
    std::swap(from, sorted);
  };
  for_each_column(
      [&]<class T>(BigArray<T>& from) {
        if constexpr (std::is_same_v<T, float>) {
          sort(from, sorted_scalars_);
        } else {
          sort(from, sorted_integers_);
        }
      },
      photons_);
}

template <template <class> class Fields>
typename PhotonMap<Fields>::Wide PhotonMap<Fields>::load(std::int32_t first) const {
  Wide result;
  Fields<InColumns>::for_each(
      [&](auto& field, const auto& columns) {
        for_each_component(
            [&](auto& to, const auto& column) {
              to = std::decay_t<decltype(to)>::load_unaligned(column.data() + first);
            },
            field, columns);
      },
      result, photons_);
  return result;
}

template <template <class> class Fields>
typename PhotonMap<Fields>::Wide PhotonMap<Fields>::gather(Int entries) const {
  Wide result;
  Fields<InColumns>::for_each(
      [&](auto& field, const auto& columns) {
        for_each_component(
            [&](auto& to, const auto& column) { to = TESSERA_ISA::gather(column.data(), entries); }, field,
            columns);
      },
      result, photons_);
  return result;
}

template <template <class> class Fields>
TESSERA_INLINE Float PhotonMap<Fields>::distance2(std::int32_t first, float x, float y, float z) const {
  const auto from = [&](const BigArray<float>& column, float coordinate) {
    return Float::load_unaligned(column.data() + first) - coordinate;
  };
  const Float dx = from(photons_.position.x, x), dy = from(photons_.position.y, y),
              dz = from(photons_.position.z, z);
  return fma(dx, dx, fma(dy, dy, dz * dz));
}

template <template <class> class Fields>
template <class Visit>
TESSERA_INLINE void PhotonMap<Fields>::for_each_near(float x, float y, float z, Visit&& visit) const {
  cells_.for_each_run(x, y, z, [&](std::int32_t begin, std::int32_t end) {
    for (std::int32_t i = begin; i < end; i += kWidth) {
      const Float d2 = distance2(i, x, y, z);
      const Mask near = Mask::first(end - i) & (d2 < radius2_);
      if (any(near)) visit(i, near, d2);
    }
  });
}

/// A query of one place, carried on where it was left.
template <template <class> class Fields>
struct PhotonMap<Fields>::Query {
  static constexpr int kMostRuns = 8;  // four rows of cells, each perhaps in two pieces
  static constexpr int kEnough = 128;  // photons found at a time: 16 lists of them stay in the cache

  float x, y, z;
  std::int32_t begin[kMostRuns], end[kMostRuns];
  int runs = 0, run = 0;
  int found = 0;
  alignas(64) std::int32_t found_entries[kEnough + kWidth];

  void start(const CellTable& cells) {
    cells.for_each_run(x, y, z, [&](std::int32_t from, std::int32_t to) {
      if (from < to) begin[runs] = from, end[runs++] = to;
    });
  }
  /// Finds more photons; false when there are none left.
  bool go_on(const PhotonMap& map) {
    found = 0;
    for (; run < runs; ++run) {
      std::int32_t& i = begin[run];
      for (; i < end[run]; i += kWidth) {
        if (found >= kEnough) return true;
        const Mask near = Mask::first(end[run] - i) & (map.distance2(i, x, y, z) < map.radius2_);
        if (any(near)) found += compress_store(Int::iota(i), near, found_entries + found);
      }
    }
    return found > 0;
  }
};

template <template <class> class Fields>
template <class Visit>
void PhotonMap<Fields>::for_each_near(Vec3 places, Mask active, Visit&& visit) const {
  alignas(64) float x[kWidth], y[kWidth], z[kWidth];
  places.x.store(x), places.y.store(y), places.z.store(z);
  Query queries[kWidth];
  const std::uint32_t lanes = active.bits();
  for (std::uint32_t left = lanes; left != 0; left &= left - 1) {
    const int lane = std::countr_zero(left);
    Query& query = queries[lane];
    query.x = x[lane], query.y = y[lane], query.z = z[lane];
    query.start(cells_);
  }
  for (bool more = true; more;) {
    more = false;
    int longest = 0;
    alignas(64) std::int32_t found[kWidth] = {};
    for (std::uint32_t left = lanes; left != 0; left &= left - 1) {
      const int lane = std::countr_zero(left);
      more |= queries[lane].go_on(*this);
      found[lane] = queries[lane].found;
      longest = std::max(longest, found[lane]);
    }
    for (int k = 0; k < longest; ++k) {
      const Mask near = Int::load(found) > k;
      alignas(64) std::int32_t entry[kWidth] = {};
      for (std::uint32_t left = near.bits(); left != 0; left &= left - 1) {
        const int lane = std::countr_zero(left);
        entry[lane] = queries[lane].found_entries[k];
      }
      visit(gather(Int::load(entry)), near);
    }
  }
}

}  // namespace tessera::render::TESSERA_ISA
