// Curves as Embree geometry.
#pragma once

#include "render/accel/embree/embree.h"

namespace tessera::render {

struct CurvesRecord;

/// Reads the record's arrays in place. Its hits have the segment's parameter in u.
RTCGeometry new_curve_geometry(RTCDevice device, const CurvesRecord& curves);

}  // namespace tessera::render
