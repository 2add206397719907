// Clipping in homogeneous coordinates [Sutherland & Hodgman 1974; Blinn & Newell 1978]: before the division,
// so that what is behind the eye does not come out in front of it.
#pragma once

#include "render/core/wide.h"

namespace tessera::render::TESSERA_ISA {

/// A corner on its way to the film: its place there times `w`, which is its depth, or 1 where lines of sight
/// are parallel.
struct ClipCorner {
  double x, y, w, depth;
};

/// A triangle that is clipped by one plane after the other has one corner more after each, at most.
struct ClipPolygon {
  ClipCorner corners[3 + 5];
  int size = 0;
};

/// Clips the polygon to depths from `nearest` on and to places of at most `reach` in x and y from the origin.
/// A side that two polygons share is cut at the same point for both.
void clip(float nearest, double reach, ClipPolygon& polygon);

}  // namespace tessera::render::TESSERA_ISA
