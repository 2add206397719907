// Points on curves.
#pragma once

#include "render/shape/surface.h"

namespace tessera::render::TESSERA_ISA {

/// Fills point, error, normals, parameters and tangents of lanes that hit the curves `record`; `o` and `d` in
/// the space that they lie in. Flat curves and cylinders turn their width to the ray. u runs along a segment
/// and v across it, so that 2 v - 1 is the offset from the axis in radii towards cross(ng, dp/du): what a
/// hair's BSDF asks for.
void curve_surface(const CurvesRecord& record, const Hit& hit, Vec3 o, Vec3 d, Mask active, Surface& s);

}  // namespace tessera::render::TESSERA_ISA
