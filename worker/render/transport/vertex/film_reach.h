// Which pixels see light that lands at a place of the film.
#pragma once

#include "render/film/film.h"
#include "render/integrator/scene_tables.h"

namespace tessera::render::TESSERA_ISA {

/// Lanes whose place on the film is seen by a pixel of the rectangle. Where the film has no edge, places on
/// one side of it are seen by pixels on another.
inline Mask lands(const SceneTables& scene, Vec2 film, const FilmRect& rect) {
  if (edges_of(scene.sensor) != RasterEdges::kOpen) return Mask::all();
  const float rx = scene.filter.x.radius, ry = scene.filter.y.radius;
  return (film.x > static_cast<float>(rect.x0) - rx) & (film.x < static_cast<float>(rect.x1) + rx) &
         (film.y > static_cast<float>(rect.y0) - ry) & (film.y < static_cast<float>(rect.y1) + ry);
}

}  // namespace tessera::render::TESSERA_ISA
