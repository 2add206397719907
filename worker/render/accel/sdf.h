// Ray intersection with grids of signed distances: Embree's callbacks, one primitive a voxel that holds a
// piece of the surface.
#pragma once

#include "render/accel/embree.h"
#include "render/accel/quadric_geometry.h"

namespace tessera::render::TESSERA_ISA {

/// The geometry's user pointer is its QuadricGeometry.
void intersect_sdf(const RTCIntersectFunctionNArguments* args);
void occluded_sdf(const RTCOccludedFunctionNArguments* args);

}  // namespace tessera::render::TESSERA_ISA
