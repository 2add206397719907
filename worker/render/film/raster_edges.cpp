#include "render/film/raster_edges.h"

namespace tessera::render {

std::vector<RasterPlace> places_beyond(RasterEdges edges, FilmSize raster, RasterPlace place, float reach_x,
                                       float reach_y) {
  std::vector<RasterPlace> beyond;
  const auto width = static_cast<float>(raster.width), height = static_cast<float>(raster.height);
  // Most places are too far from the edge.
  const bool inner =
      place.x > reach_x && place.x < width - reach_x && place.y > reach_y && place.y < height - reach_y;
  if (edges == RasterEdges::kOpen || inner) return beyond;
  for (const int down : {-1, 0, 1}) {
    if (down != 0 && edges == RasterEdges::kRound) continue;
    const float y = down == 0 ? place.y : down < 0 ? -place.y : 2 * height - place.y;
    if (!(y > -reach_y && y < height + reach_y)) continue;
    for (const int right : {-1, 0, 1}) {
      if (down == 0 && right == 0) continue;
      float x;
      if (edges == RasterEdges::kMirrored) {
        x = right == 0 ? place.x : right < 0 ? -place.x : 2 * width - place.x;
      } else {
        // Over a pole, the meridian is the opposite one.
        const float opposite = place.x < width / 2 ? place.x + width / 2 : place.x - width / 2;
        x = (down == 0 ? place.x : opposite) + static_cast<float>(right) * width;
      }
      if (x > -reach_x && x < width + reach_x) beyond.push_back({x, y});
    }
  }
  return beyond;
}

}  // namespace tessera::render
