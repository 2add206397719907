// A film cut into the parts of a phase.
#pragma once

#include <cstdint>

#include "render/film/film.h"
#include "render/film/tile_request.h"

namespace tessera::render {

/// The part's pixels: a cell of a grid of as many columns as rows, or the next best number, over the film.
/// Empty where the film has too few pixels.
inline FilmRect film_part(std::int32_t width, std::int32_t height, const PartRequest& part) {
  std::uint32_t columns = 1;
  while ((columns + 1) * (columns + 1) <= part.parts) ++columns;
  while (part.parts % columns != 0) --columns;
  const std::uint32_t rows = part.parts / columns, row = part.part / columns, column = part.part % columns;
  const auto border = [](std::int32_t size, std::uint32_t i, std::uint32_t cells) {
    return static_cast<std::uint32_t>(std::uint64_t{static_cast<std::uint32_t>(size)} * i / cells);
  };
  return {border(width, column, columns), border(height, row, rows), border(width, column + 1, columns),
          border(height, row + 1, rows)};
}

}  // namespace tessera::render
