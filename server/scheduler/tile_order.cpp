#include "scheduler/tile_order.h"

#include <algorithm>

namespace tessera::server {

std::int64_t TileOrder::Axis::last_within(std::int64_t ring) const {
  const std::int64_t last = std::min(ring, count - 1);
  return (count - 1 - last) % 2 == 0 ? last : last - 1;
}

TileOrder::Tile TileOrder::tile(std::uint32_t index) const {
  // The ring, which is the first with more tiles within it than come before this one.
  std::int64_t ring = 0, end = std::max(columns_.count, rows_.count);
  while (ring < end) {
    const std::int64_t middle = ring + (end - ring) / 2;
    count_within(middle) > index ? end = middle : ring = middle + 1;
  }
  std::int64_t left = index - (ring == 0 ? 0 : count_within(ring - 1));
  const auto at = [&](std::int64_t x, std::int64_t y) {
    return Tile{.column = columns_.index_of(x), .row = rows_.index_of(y)};
  };
  // Its sides in turn. A corner is of the side that comes first: the upper ones of the top, the lower right
  // one of the right side, the lower left one of the bottom.
  const std::int64_t x_end = columns_.last_within(ring), y_end = rows_.last_within(ring);
  const bool has_top = rows_.has(ring), has_right = columns_.has(ring);
  if (has_top) {
    if (left <= x_end) return at(-x_end + 2 * left, -ring);
    left -= x_end + 1;
  }
  if (has_right) {
    const std::int64_t begin = has_top ? -ring + 2 : -y_end;
    const std::int64_t count = (y_end - begin) / 2 + 1;
    if (left < count) return at(ring, begin + 2 * left);
    left -= count;
  }
  if (has_top) {
    const std::int64_t begin = has_right ? ring - 2 : x_end;
    const std::int64_t count = (begin + x_end) / 2 + 1;
    if (left < count) return at(begin - 2 * left, ring);
    left -= count;
  }
  return at(-ring, (has_top ? ring - 2 : y_end) - 2 * left);
}

}  // namespace tessera::server
