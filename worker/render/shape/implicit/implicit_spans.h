// Implicit surfaces as solids.
#pragma once

#include "render/core/wide.h"
#include "render/shape/csg/csg_sweep.h"
#include "render/shape/implicit/implicit_record.h"

namespace tessera::render::TESSERA_ISA {

/// Lines o + s d in an implicit surface's object space.
struct ImplicitLines {
  alignas(64) double o[3][kWidth] = {}, d[3][kWidth] = {};
  std::uint32_t active = 0;  // lanes
};

/// Adds to `crossings`, one of which is a lane's, where lines go into what is within the bounds of the
/// surface and has f < 0, and where they leave it. `offset` of each lane is added to the places.
void add_crossings(const ImplicitRecord& surface, const ImplicitLines& lines, const double (&offset)[kWidth],
                   std::int32_t solid, CsgCrossings* crossings);

}  // namespace tessera::render::TESSERA_ISA
