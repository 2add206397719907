// Places of a scene whose objects hold others: the unrolled graph, counted depth first. An instance's own
// object comes first, then what its instances place, in their order. So a place's number says which instances
// lead to it, though no array has as many entries as there are places.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "render/shape/exact_affine.h"
#include "render/shape/shape_table.h"

namespace tessera::render {

/// In a hit, bits 0 to 30 are HitArrays::instance, those above HitArrays::upper.
inline constexpr int kPlaceBits = 31;
constexpr std::int64_t place_number(std::int32_t instance, std::int32_t upper) {
  return std::int64_t{upper} << kPlaceBits | instance;
}
constexpr std::int32_t lower_part(std::int64_t place) {
  return static_cast<std::int32_t>(place & ((std::int64_t{1} << kPlaceBits) - 1));
}
constexpr std::int32_t upper_part(std::int64_t place) {
  return static_cast<std::int32_t>(place >> kPlaceBits);
}

/// Sets InstanceRecord::first_place of all instances. Objects follow those that they hold, and there are less
/// than 2^62 places.
inline void number_places(ShapeTable& table) {
  std::vector<std::int64_t> tree_sizes;  // sizes of the trees, one for each object
  const auto number = [&](std::span<InstanceRecord> neighbours) {
    std::int64_t next = 0;
    for (InstanceRecord& instance : neighbours) {
      instance.first_place = next;
      next += tree_sizes[static_cast<std::size_t>(instance.object)];
    }
    return next;
  };
  for (const ObjectRange& object : table.objects) {
    const auto first = static_cast<std::size_t>(object.first_inner);
    tree_sizes.push_back(
        1 + number(std::span(table.inner).subspan(first, static_cast<std::size_t>(object.inner_count))));
  }
  number(table.instances);
}

/// The last of the instances whose places begin at `place` or before.
inline const InstanceRecord& instance_at(std::span<const InstanceRecord> instances, std::int64_t place) {
  const auto after =
      std::upper_bound(instances.begin(), instances.end(), place,
                       [](std::int64_t p, const InstanceRecord& r) { return p < r.first_place; });
  return *(after - 1);
}

/// Number of the place of what an instance in an object places, where that object's own is `holder`.
inline std::int64_t place_within(std::int64_t holder, const InstanceRecord& inner) {
  return holder + 1 + inner.first_place;
}

/// Calls f(instance) for all that lead to a place, from the world on.
template <class F>
void for_each_level(const ShapeTable& table, std::int64_t place, F&& f) {
  std::span<const InstanceRecord> neighbours = table.instances;
  for (;;) {
    const InstanceRecord& instance = instance_at(neighbours, place);
    f(instance);
    place -= instance.first_place;
    if (place == 0) return;
    --place;
    neighbours = table.inner_of(table.objects[static_cast<std::size_t>(instance.object)]);
  }
}

struct PlaceMap {
  ExactAffine render_from_object;
  double shift;  // size of the coordinates that it was computed from, as MovedAffine has it
};

/// Map of a place at `time`, from 0 to 1: the product of its instances' maps.
inline PlaceMap map_of_place(const ShapeTable& table, std::int64_t place, float time) {
  PlaceMap all{{{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}}, 0};
  double shifts[3] = {0, 0, 0};
  for_each_level(table, place, [&](const InstanceRecord& instance) {
    const ExactAffine next = placement_at(table, instance, time);
    for (int i = 0; i < 3; ++i) {
      const double* const row = all.render_from_object.m + 4 * i;
      for (int k = 0; k < 3; ++k) shifts[i] += std::abs(row[k] * next.m[4 * k + 3]);
    }
    all.render_from_object = product(all.render_from_object, next);
  });
  all.shift = std::max({shifts[0], shifts[1], shifts[2]});
  return all;
}

}  // namespace tessera::render
