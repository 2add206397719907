// The camera's matrices, as OpenEXR's standard attributes have them.
#pragma once

#include "image/image.h"
#include "tessera/v1/camera.pb.h"

namespace tessera::client {

/// Adds "worldToCamera" and, of cameras that project to a plane, "worldToNDC", which takes points to (0, 0)
/// in the upper left and (1, 1) in the lower right corner of the display window [ImfStandardAttributes.h].
/// A camera that moves has those of the time when the shutter opens. Nothing where the camera's transform is
/// singular.
void add_camera_facts(const v1::Camera& camera, Image& image);

}  // namespace tessera::client
