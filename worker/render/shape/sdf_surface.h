// Points on grids of signed distances.
#pragma once

#include "render/shape/surface.h"

namespace tessera::render::TESSERA_ISA {

/// Fills point, error, normals and parameters (zero) of lanes that hit the grid `shape`; `o` and `d` in the
/// space that the shape is placed in.
void sdf_surface(const ShapeTable& table, const ShapeRecord& shape, const Hit& hit, Vec3 o, Vec3 d,
                 Mask active, Surface& s);

}  // namespace tessera::render::TESSERA_ISA
