// Ray intersection with spheres and disks: Embree's callbacks for user geometry.
#pragma once

#include "render/accel/embree.h"
#include "render/accel/quadric_geometry.h"

namespace tessera::render::TESSERA_ISA {

/// The geometry's user pointer is its QuadricGeometry.
void intersect_quadric(const RTCIntersectFunctionNArguments* args);
void occluded_quadric(const RTCOccludedFunctionNArguments* args);

}  // namespace tessera::render::TESSERA_ISA
