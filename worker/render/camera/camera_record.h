// The camera as the kernels read it.
#pragma once

#include "render/core/affine_data.h"

namespace tessera::render {

struct CameraRecord {
  // Camera space (x right, y up, z forward) to render space. Without translation: render space is centred on the camera.
  Affine render_from_camera;
  // A film position (pixels) times these plus offsets is a point on the plane z = 1 of camera space.
  float scale_x = 1, scale_y = 1, offset_x = 0, offset_y = 0;
  float lens_radius = 0;
  float focal_distance = 1;
};

}  // namespace tessera::render
