// Rasters that show all directions have no edge: beyond it, the same directions are seen again.
#pragma once

#include <cstdint>
#include <vector>

#include "render/film/sample_source.h"

namespace tessera::render {

/// The things that the places beyond the edge of a raster see.
enum class RasterEdges : std::uint8_t {
  kOpen,      // what no place within it sees
  kRound,     // left and right, what the other side sees
  kOverPole,  // the same, and above and below, what lies over the pole of a globe
  kMirrored   // what the places at the same distance within see
};

/// A place of a raster, pixels from the upper left corner.
struct RasterPlace {
  float x, y;
};

/// Other places, at most `reach_x` and `reach_y` pixels beyond the edge, that see what a place within the
/// raster sees. Light that lands there has its part in the pixels at the edge, too.
std::vector<RasterPlace> places_beyond(RasterEdges edges, FilmSize raster, RasterPlace place, float reach_x,
                                       float reach_y);

}  // namespace tessera::render
