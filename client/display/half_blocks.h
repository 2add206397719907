// Pictures in a terminal.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "display/growing_image.h"

namespace tessera::client {

/// Cells, of which a character has two, one above the other, for a picture of `crop` in a terminal of so many
/// columns and lines: as large as it can be seen whole, and as wide as the picture is.
std::pair<std::int32_t, std::int32_t> half_block_cells(const Window& crop, int columns, int lines);

/// Lines of "upper half block" (U+2580) in 24-bit colours (ISO 8613-6), sRGB; spaces where there are no
/// samples.
std::string half_blocks(const GrowingImage& image);

}  // namespace tessera::client
