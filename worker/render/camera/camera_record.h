// The camera as the kernels read it.
#pragma once

#include <cstdint>
#include <vector>

#include "render/core/affine_data.h"

namespace tessera::render {

enum class CameraKind : std::int32_t { kPerspective, kOrthographic, kEquirectangular, kOctahedral };

struct CameraRecord {
  CameraKind kind = CameraKind::kPerspective;
  // Camera space (x right, y up, z forward) to render space. Without translation: render space is centred on
  // the camera.
  Affine render_from_camera;
  // Poses of a camera that moves, at evenly spaced times (core/motion.h), with the way that it went since
  // the shutter opened.
  std::vector<Affine> steps;
  // A film position (pixels) times these plus offsets: a point on the plane z = 1 of camera space
  // (kPerspective), the place of a ray in the plane z = 0 (kOrthographic), or a point of the unit square of
  // the sphere's map.
  float scale_x = 1, scale_y = 1, offset_x = 0, offset_y = 0;
  float lens_radius = 0;
  float focal_distance = 1;
  // Depths (along z; distances for cameras that see all around) between which things are seen; far_clip 0: no
  // limit.
  float near_clip = 0, far_clip = 0;
  std::int32_t width = 1, height = 1;  // of the film, pixels
  std::int32_t medium = -1;            // that the camera stands in
};

/// Whether points of the scene can be connected to the camera.
inline bool sees_points(const CameraRecord& camera) {
  return camera.kind == CameraKind::kPerspective || camera.kind == CameraKind::kOrthographic;
}

}  // namespace tessera::render
