#include "render/camera/camera.h"

#include <cmath>

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

CameraConnection connect_to_camera(const CameraRecord& camera, Vec3 point, Vec2 u_lens, Mask active) {
  // Camera space: the axes of the camera's frame are orthogonal, but may be scaled.
  const float* m = camera.render_from_camera.m;
  const auto along = [&](int axis) {
    const Vec3 column{Float(m[axis]), Float(m[4 + axis]), Float(m[8 + axis])};
    return dot(point, column) / length_squared(column);
  };
  const Vec3 p{along(0), along(1), along(2)};
  Vec3 lens{Float(0.0f), Float(0.0f), Float(0.0f)};
  if (camera.lens_radius > 0) {
    const Vec2 disk = square_to_disk(u_lens);
    lens = {disk.x * camera.lens_radius, disk.y * camera.lens_radius, Float(0.0f)};
  }
  const Mask in_front = active & (p.z > 0.0f) & (p.z > camera.near_clip);
  const Float depth = select(in_front, p.z, 1.0f);
  const float pixel_area = std::abs(camera.scale_x * camera.scale_y);
  CameraConnection result;
  Vec2 place;
  if (camera.kind == CameraKind::kOrthographic) {
    // With a lens, rays through one film point meet at the focal distance.
    const Float spread = camera.lens_radius > 0 ? 1.0f - depth * (1 / camera.focal_distance) : Float(1.0f);
    place = {p.x - lens.x * spread, p.y - lens.y * spread};
    lens = {lens.x + place.x, lens.y + place.y, Float(0.0f)};
  } else if (camera.lens_radius > 0) {
    // Where the ray from the lens meets the plane of focus, seen from the pinhole.
    const Float t = camera.focal_distance / depth;
    place = {(lens.x + (p.x - lens.x) * t) * (1 / camera.focal_distance), (lens.y + (p.y - lens.y) * t) * (1 / camera.focal_distance)};
  } else {
    place = {p.x / depth, p.y / depth};
  }
  result.film = {(place.x - camera.offset_x) * (1 / camera.scale_x), (place.y - camera.offset_y) * (1 / camera.scale_y)};
  result.lens = transform_vector(camera.render_from_camera, lens);
  const Vec3 to_point = p - lens;
  const Float distance_squared = length_squared(to_point);
  const Float cosine = depth / sqrt(distance_squared);
  // Orthographic rays through one lens point are parallel; perspective ones cross the plane z = 1 under the cosine.
  result.importance = camera.kind == CameraKind::kOrthographic ? 1.0f / (cosine * pixel_area)
                                                               : 1.0f / (distance_squared * cosine * cosine * cosine * pixel_area);
  result.depth = p.z;
  result.valid = in_front;
  if (camera.far_clip > 0) result.valid &= p.z <= camera.far_clip;
  return result;
}

Float visible_distance(const CameraRecord& camera, Vec3 direction) {
  return (camera.far_clip - camera.near_clip) * length_per_depth(camera, direction);
}

}  // namespace tessera::render::TESSERA_ISA
