// The part of a triangle that lies within a box: what makes the splits of a kd-tree perfect.
#pragma once

#include "render/accel/structure/primitive.h"

namespace tessera::render {

/// Bounds of the part of a primitive that lies in `cell`, no larger than the cell; empty where it does not
/// reach into it. A triangle is clipped [Sutherland & Hodgman 1974], so one that crosses a cell without a
/// vertex in it is found, and one whose box alone crosses is not; of others the box is taken.
Box part_within(const Primitive& primitive, const Box& cell);

}  // namespace tessera::render
