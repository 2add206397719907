// Alpha-tested triangles: an Embree filter that lets rays pass with probability 1 - alpha.
#pragma once

#include "render/accel/embree/alpha_geometry.h"
#include "render/accel/embree/embree.h"

namespace tessera::render::TESSERA_ISA {

/// For hits and occlusion alike. The geometry's user pointer is its AlphaGeometry. The choice is a hash of
/// the ray, so it is the same on every machine.
void filter_alpha(const RTCFilterFunctionNArguments* args);

}  // namespace tessera::render::TESSERA_ISA
