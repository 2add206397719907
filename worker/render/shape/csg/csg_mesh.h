// Crossings of rays and closed meshes.
#pragma once

#include "render/shape/csg/csg_sweep.h"

namespace tessera::render::TESSERA_ISA {

/// Adds all crossings of the line o + s d, in unit space, with the mesh. Their number is even: a line through
/// an edge or a corner is taken to pass beside it, on the same side for all triangles that meet there.
void add_crossings(const CsgMesh& mesh, const double (&o)[3], const double (&d)[3], std::int32_t solid,
                   CsgCrossings& crossings);

}  // namespace tessera::render::TESSERA_ISA
