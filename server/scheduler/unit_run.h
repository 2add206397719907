// Units that are leased, rendered and returned as one.
#pragma once

#include <cstdint>

namespace tessera::server {

/// Units of one tile whose sample ranges follow each other and together are one node of the sum tree, so that
/// one result can cover them (wire/tile_result.h). WorkPlan::run makes those of more than one unit.
struct UnitRun {
  std::uint32_t first = 0;  // a unit
  std::uint32_t count = 1;  // number of units, one a sample range; a power of two
  std::uint32_t step = 1;   // distance from one of its units to the next: the number of tiles

  std::uint32_t operator[](std::uint32_t i) const { return first + i * step; }
  bool operator==(const UnitRun&) const = default;

  /// Over its units.
  struct Iterator {
    std::uint32_t unit, step;
    std::uint32_t operator*() const { return unit; }
    Iterator& operator++() {
      unit += step;
      return *this;
    }
    bool operator==(const Iterator&) const = default;
  };
  Iterator begin() const { return {first, step}; }
  Iterator end() const { return {first + count * step, step}; }
};

}  // namespace tessera::server
