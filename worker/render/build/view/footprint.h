// What a pixel of a camera covers, for the kernels.
#pragma once

#include "render/camera/camera_record.h"
#include "render/camera/footprint_record.h"

namespace tessera::render {

/// `part`: of a pixel's width; 0: no footprints.
FootprintRecord footprint_of(const CameraRecord& camera, double part);

}  // namespace tessera::render
