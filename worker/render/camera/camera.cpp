#include "render/camera/camera.h"

#include "render/core/affine.h"
#include "render/sampling/sphere_map.h"
#include "render/sampling/warp.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// A ray in camera space; the direction has any length.
struct CameraSpaceRay {
  Vec3 origin, direction;
};

/// Pinhole or thin lens [Kolb, Mitchell & Hanrahan 1995]: all rays through one film point meet on the plane of focus.
CameraSpaceRay perspective_ray(const CameraRecord& camera, Vec2 film, Vec2 u_lens) {
  const Vec3 through{film.x, film.y, Float(1.0f)};
  if (camera.lens_radius <= 0) return {{Float(0.0f), Float(0.0f), Float(0.0f)}, through};
  const Vec2 lens = square_to_disk(u_lens);
  const Vec3 origin{lens.x * camera.lens_radius, lens.y * camera.lens_radius, Float(0.0f)};
  return {origin, through * Float(camera.focal_distance) - origin};
}

CameraSpaceRay orthographic_ray(const CameraRecord& camera, Vec2 film, Vec2 u_lens) {
  Vec3 origin{film.x, film.y, Float(0.0f)}, direction{Float(0.0f), Float(0.0f), Float(1.0f)};
  if (camera.lens_radius > 0) {
    const Vec2 lens = square_to_disk(u_lens);
    const Vec3 focus{film.x, film.y, Float(camera.focal_distance)};
    origin = origin + Vec3{lens.x * camera.lens_radius, lens.y * camera.lens_radius, Float(0.0f)};
    direction = focus - origin;
  }
  return {origin, direction};
}

/// All around, +y up [pbrt-v4 SphericalCamera].
CameraSpaceRay spherical_ray(const CameraRecord& camera, Vec2 square) {
  const Vec3 zero{Float(0.0f), Float(0.0f), Float(0.0f)};
  if (camera.kind == CameraKind::kOctahedral) {
    // Pixel filters reach beyond the square; it goes on mirrored there.
    const auto fold = [](Float x) { return 1.0f - abs(1.0f - abs(x)); };
    const Vec3 w = direction_from_octahedral({fold(square.x), fold(square.y)});
    return {zero, {w.x, w.z, w.y}};
  }
  const Float theta = kPi * square.y, phi = 2.0f * kPi * square.x;
  const Float sin_theta = sin(theta);
  return {zero, {sin_theta * cos(phi), cos(theta), sin_theta * sin(phi)}};
}

bool sees_all_around(const CameraRecord& camera) {
  return camera.kind == CameraKind::kEquirectangular || camera.kind == CameraKind::kOctahedral;
}

/// Length of a ray of unit direction for every unit of depth.
Float length_per_depth(const CameraRecord& camera, Vec3 direction) {
  if (sees_all_around(camera)) return Float(1.0f);
  const float* m = camera.render_from_camera.m;
  const Vec3 forward = normalize(Vec3{Float(m[2]), Float(m[6]), Float(m[10])});
  return 1.0f / max(dot(direction, forward), 1e-6f);
}

}  // namespace

CameraRay sample_camera_ray(const CameraRecord& camera, Vec2 film, Vec2 u_lens) {
  const Vec2 place{fma(film.x, Float(camera.scale_x), Float(camera.offset_x)),
                   fma(film.y, Float(camera.scale_y), Float(camera.offset_y))};
  CameraSpaceRay ray;
  switch (camera.kind) {
    case CameraKind::kPerspective: ray = perspective_ray(camera, place, u_lens); break;
    case CameraKind::kOrthographic: ray = orthographic_ray(camera, place, u_lens); break;
    default: ray = spherical_ray(camera, place); break;
  }
  CameraRay result{transform_vector(camera.render_from_camera, ray.origin),
                   normalize(transform_vector(camera.render_from_camera, ray.direction))};
  if (camera.near_clip > 0) {
    result.origin = result.origin + result.direction * (camera.near_clip * length_per_depth(camera, result.direction));
  }
  return result;
}

Float visible_distance(const CameraRecord& camera, Vec3 direction) {
  return (camera.far_clip - camera.near_clip) * length_per_depth(camera, direction);
}

}  // namespace tessera::render::TESSERA_ISA
