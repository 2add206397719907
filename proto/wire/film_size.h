// Sizes of films: client, coordinator and worker hold each other to the same.
#pragma once

#include <cstdint>

namespace tessera::wire {

/// Largest width or height, pixels: places on a film are floats, which hold sixteenths of a pixel there.
inline constexpr std::uint32_t kMaxFilmSide = 1'000'000;
/// Most pixels of a film.
inline constexpr std::uint64_t kMaxFilmPixels = std::uint64_t{1} << 32;

/// Whether a film may have these sides, pixels.
constexpr bool is_film_size(std::uint64_t width, std::uint64_t height) {
  return width > 0 && height > 0 && width <= kMaxFilmSide && height <= kMaxFilmSide &&
         width * height <= kMaxFilmPixels;
}

/// Such sides, in messages about others.
inline constexpr char kFilmSizes[] = "1 to 1000000 each way, and at most 2^32 in all";

}  // namespace tessera::wire
