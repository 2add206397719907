// From a place on the film to a ray.
#pragma once

#include "render/camera/camera_record.h"
#include "render/core/vec.h"

namespace tessera::render::TESSERA_ISA {

struct CameraRay {
  Vec3 origin;     // render space
  Vec3 direction;  // unit length
};

/// `film` is in pixels from the upper left corner of the film; `u_lens` uniform in the unit square.
CameraRay sample_camera_ray(const CameraRecord& camera, Vec2 film, Vec2 u_lens);

/// The distance along camera rays of unit `direction`, from their origins, up to which things are seen.
Float visible_distance(const CameraRecord& camera, Vec3 direction);

}  // namespace tessera::render::TESSERA_ISA
