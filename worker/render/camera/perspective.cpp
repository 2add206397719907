#include "render/camera/perspective.h"

#include "render/core/affine.h"
#include "render/sampling/warp.h"

namespace tessera::render::TESSERA_ISA {

CameraRay sample_camera_ray(const CameraRecord& camera, Vec2 film, Vec2 u_lens) {
  Vec3 origin{Float(0.0f), Float(0.0f), Float(0.0f)};
  Vec3 direction{fma(film.x, Float(camera.scale_x), Float(camera.offset_x)),
                 fma(film.y, Float(camera.scale_y), Float(camera.offset_y)), Float(1.0f)};
  if (camera.lens_radius > 0) {
    // All rays through one film point meet on the plane of focus.
    const Vec2 lens = square_to_disk(u_lens);
    origin = {lens.x * camera.lens_radius, lens.y * camera.lens_radius, Float(0.0f)};
    direction = direction * Float(camera.focal_distance) - origin;
  }
  return {transform_vector(camera.render_from_camera, origin),
          normalize(transform_vector(camera.render_from_camera, direction))};
}

}  // namespace tessera::render::TESSERA_ISA
