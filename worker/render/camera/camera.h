// From a place on the film to a ray.
#pragma once

#include "render/camera/camera_record.h"
#include "render/core/vec.h"

namespace tessera::render::TESSERA_ISA {

struct CameraRay {
  Vec3 origin;     // render space
  Vec3 direction;  // unit length
};

/// `film` is in pixels from the upper left corner of the film; `u_lens` uniform in the unit square. Here and
/// below, `time` goes from 0 (the shutter opens) to 1; cameras that stand still do not look at it.
CameraRay sample_camera_ray(const CameraRecord& camera, Vec2 film, Vec2 u_lens, Float time);

/// How a point of the scene is seen through one point of the lens.
struct CameraConnection {
  Vec3 lens;  // point of the lens (kOrthographic: where the ray to the point begins), render space
  Vec2 film;  // pixels from the upper left corner
  // Radiance that leaves the point towards the lens, times this and the cosine there, is the point's part of
  // the integral over surfaces that gives a pixel's value, for a box filter of one pixel.
  Float importance;
  Float depth;  // along the camera's z axis
  Mask valid;   // in front of the camera and within its clipping distances
};

/// For cameras that see points.
CameraConnection connect_to_camera(const CameraRecord& camera, Vec3 point, Vec2 u_lens, Float time,
                                   Mask active);

/// A normal of render space in camera space, at `time`: unit length, as seen in the picture.
Vec3 normal_in_camera(const CameraRecord& camera, Vec3 normal, Float time);

/// Width of what one pixel sees, `distance` along its ray, in the middle of the film.
Float pixel_width(const CameraRecord& camera, Float distance);

/// The distance along camera rays of unit `direction`, from their origins, up to which things are seen.
Float visible_distance(const CameraRecord& camera, Vec3 direction, Float time);

}  // namespace tessera::render::TESSERA_ISA
