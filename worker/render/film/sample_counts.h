// How many samples each pixel takes, known before any is taken.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "render/film/film.h"
#include "wire/limits.h"

namespace tessera::render {

/// One count for each block of wire::kNoiseBlock pixels each way, on the film's grid.
struct SampleCounts {
  FilmRect blocks;                    // a rectangle that is not empty
  std::vector<std::uint32_t> counts;  // rows from the top
  bool even = false;                  // All counts are the same.

  /// Sample count of a pixel of the film, or, modulo 2^32, of a border around it. What is beyond `blocks`
  /// takes as many as the nearest of them.
  std::uint32_t at(std::uint32_t x, std::uint32_t y) const {
    const auto block = [](std::uint32_t place, std::uint32_t begin, std::uint32_t end) {
      constexpr auto kSide = static_cast<std::int64_t>(wire::kNoiseBlock);
      const std::int64_t pixel = static_cast<std::int32_t>(place);
      return static_cast<std::size_t>(
          std::clamp<std::int64_t>(pixel < 0 ? -1 : pixel / kSide, begin, std::int64_t{end} - 1) - begin);
    };
    return counts[block(y, blocks.y0, blocks.y1) * blocks.width() + block(x, blocks.x0, blocks.x1)];
  }
};

}  // namespace tessera::render
