#include "render/textbook/preview/clip.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Keeps the part of the polygon in which `height`, linear in a corner's coordinates, is not negative.
template <class Height>
void clip_by(Height height, ClipPolygon& polygon) {
  const ClipPolygon before = polygon;
  polygon.size = 0;
  for (int i = 0; i < before.size; ++i) {
    const ClipCorner& from = before.corners[i];
    const ClipCorner& to = before.corners[(i + 1) % before.size];
    const double h_from = height(from), h_to = height(to);
    if (h_from >= 0) polygon.corners[polygon.size++] = from;
    if ((h_from >= 0) == (h_to >= 0)) continue;
    // From the inner corner to the outer one, whichever way round the polygon goes.
    const bool leaves = h_from >= 0;
    const ClipCorner &inner = leaves ? from : to, &outer = leaves ? to : from;
    const double h_inner = leaves ? h_from : h_to, h_outer = leaves ? h_to : h_from;
    const double t = h_inner / (h_inner - h_outer);
    const auto between = [t](double a, double b) { return a + t * (b - a); };
    polygon.corners[polygon.size++] = {between(inner.x, outer.x), between(inner.y, outer.y),
                                       between(inner.w, outer.w), between(inner.depth, outer.depth)};
  }
}

}  // namespace

void clip(float nearest, double reach, ClipPolygon& polygon) {
  clip_by([=](const ClipCorner& c) { return c.depth - double{nearest}; }, polygon);
  clip_by([=](const ClipCorner& c) { return reach * c.w - c.x; }, polygon);
  clip_by([=](const ClipCorner& c) { return reach * c.w + c.x; }, polygon);
  clip_by([=](const ClipCorner& c) { return reach * c.w - c.y; }, polygon);
  clip_by([=](const ClipCorner& c) { return reach * c.w + c.y; }, polygon);
}

}  // namespace tessera::render::TESSERA_ISA
