// The order in which the tiles of a picture are handed out.
#pragma once

#include <cstdint>

namespace tessera::server {

/// The tiles of a grid by rings around its middle, each ring in one turn: clockwise from its upper left
/// corner. Computed when asked for, in O(log n), so that it takes no memory.
class TileOrder {
 public:
  TileOrder() = default;
  TileOrder(std::uint32_t columns, std::uint32_t rows)
      : columns_{static_cast<std::int64_t>(columns)}, rows_{static_cast<std::int64_t>(rows)} {}

  std::uint32_t count() const { return static_cast<std::uint32_t>(columns_.count * rows_.count); }

  struct Tile {
    std::uint32_t column = 0, row = 0;
  };
  /// The tile whose turn is the `index`th, from 0; below count().
  Tile tile(std::uint32_t index) const;

 private:
  /// Columns, or rows. Places are twice the offset from the middle, so that even numbers of them have a
  /// middle as well: they are 2 apart, and the last one is count - 1.
  struct Axis {
    std::int64_t count = 0;
    /// The last place within a ring, which may lie between two places or beyond the last one; -1: there is
    /// none.
    std::int64_t last_within(std::int64_t ring) const;
    std::int64_t count_within(std::int64_t ring) const { return last_within(ring) + 1; }
    /// Whether a ring goes along the places at its own distance.
    bool has(std::int64_t ring) const { return last_within(ring) == ring; }
    std::uint32_t index_of(std::int64_t place) const {
      return static_cast<std::uint32_t>((place + count - 1) / 2);
    }
  };

  /// Tiles of this ring and those within it.
  std::int64_t count_within(std::int64_t ring) const {
    return columns_.count_within(ring) * rows_.count_within(ring);
  }

  Axis columns_, rows_;
};

}  // namespace tessera::server
