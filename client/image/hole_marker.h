// The mark that a picture shows where nothing was rendered.
#pragma once

#include <cstdint>
#include <string_view>

namespace tessera::client {

/// Whether holes are marked in a channel: together, red and blue are a checkerboard of black and magenta,
/// which nobody takes for a dark corner.
inline bool marks_holes(std::string_view channel) { return channel == "R" || channel == "B"; }

/// The value of such a channel at a pixel of the film.
inline float hole_marker(std::int32_t x, std::int32_t y) {
  constexpr std::int32_t kSquare = 8;  // pixels
  return (x / kSquare + y / kSquare) % 2 == 0 ? 1.0f : 0.0f;
}

}  // namespace tessera::client
