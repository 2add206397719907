#include "render/camera/camera.h"

#include <algorithm>
#include <cmath>

#include "render/core/affine.h"
#include "render/core/constants.h"
#include "render/core/motion.h"
#include "render/sampling/sphere_map.h"
#include "render/sampling/warp.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// A ray in camera space; the direction has any length.
struct CameraSpaceRay {
  Vec3 origin, direction;
};

/// Pinhole or thin lens [Kolb, Mitchell & Hanrahan 1995]: all rays through one film point meet on the plane
/// of focus.
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

/// Camera space to render space.
WideAffine pose_at(const CameraRecord& camera, Float time) {
  if (camera.steps.empty()) return broadcast(camera.render_from_camera);
  const auto segments = static_cast<std::int32_t>(camera.steps.size()) - 1;
  return affine_at(camera.steps.data(), Int(0), Int(segments), time, Mask::all()).map;
}

Vec3 place_of(const WideAffine& pose) { return {pose.m[3], pose.m[7], pose.m[11]}; }

/// Whether the camera is anywhere but at the origin of render space.
bool is_elsewhere(const CameraRecord& camera) {
  const float* m = camera.render_from_camera.m;
  return !camera.steps.empty() || m[3] != 0 || m[7] != 0 || m[11] != 0;
}

/// Length of a ray of unit direction for every unit of depth.
Float length_per_depth(const CameraRecord& camera, const WideAffine& pose, Vec3 direction) {
  if (sees_all_around(camera)) return Float(1.0f);
  const Vec3 forward = normalize(Vec3{pose.m[2], pose.m[6], pose.m[10]});
  return 1.0f / max(dot(direction, forward), 1e-6f);
}

}  // namespace

CameraRay sample_camera_ray(const CameraRecord& camera, Vec2 film, Vec2 u_lens, Float time) {
  const Vec2 place{fma(film.x, Float(camera.scale_x), Float(camera.offset_x)),
                   fma(film.y, Float(camera.scale_y), Float(camera.offset_y))};
  CameraSpaceRay ray;
  switch (camera.kind) {
    case CameraKind::kPerspective:
      ray = perspective_ray(camera, place, u_lens);
      break;
    case CameraKind::kOrthographic:
      ray = orthographic_ray(camera, place, u_lens);
      break;
    default:
      ray = spherical_ray(camera, place);
      break;
  }
  const WideAffine pose = pose_at(camera, time);
  CameraRay result{transform_vector(pose, ray.origin), normalize(transform_vector(pose, ray.direction))};
  if (is_elsewhere(camera)) result.origin = result.origin + place_of(pose);
  if (camera.near_clip > 0) {
    const Float per_depth = length_per_depth(camera, pose, result.direction);
    result.origin = fma(result.direction, camera.near_clip * per_depth, result.origin);
  }
  return result;
}

CameraConnection connect_to_camera(const CameraRecord& camera, Vec3 point, Vec2 u_lens, Float time,
                                   Mask active) {
  const WideAffine pose = pose_at(camera, time);
  if (is_elsewhere(camera)) point = point - place_of(pose);
  // Camera space: the axes of the camera's frame are orthogonal, but may be scaled.
  const auto axis = [&](int a) { return Vec3{pose.m[a], pose.m[4 + a], pose.m[8 + a]}; };
  const auto along = [&](int a) { return dot(point, axis(a)) / length_squared(axis(a)); };
  const Vec3 p{along(0), along(1), along(2)};
  const Float unit_of_depth = length(axis(2));
  Vec3 lens{Float(0.0f), Float(0.0f), Float(0.0f)};
  if (camera.lens_radius > 0) {
    const Vec2 disk = square_to_disk(u_lens);
    lens = {disk.x * camera.lens_radius, disk.y * camera.lens_radius, Float(0.0f)};
  }
  const Mask in_front = active & (p.z > 0.0f) & (p.z * unit_of_depth > camera.near_clip);
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
    place = {(lens.x + (p.x - lens.x) * t) * (1 / camera.focal_distance),
             (lens.y + (p.y - lens.y) * t) * (1 / camera.focal_distance)};
  } else {
    place = {p.x / depth, p.y / depth};
  }
  result.film = {(place.x - camera.offset_x) * (1 / camera.scale_x),
                 (place.y - camera.offset_y) * (1 / camera.scale_y)};
  result.lens = transform_vector(pose, lens);
  if (is_elsewhere(camera)) result.lens = result.lens + place_of(pose);
  const Vec3 to_point = p - lens;
  const Float distance_squared = length_squared(to_point);
  const Float cosine = depth / sqrt(distance_squared);
  // Orthographic rays through one lens point are parallel; perspective ones cross the plane z = 1 under the
  // cosine.
  result.importance = camera.kind == CameraKind::kOrthographic
                          ? 1.0f / (cosine * pixel_area)
                          : 1.0f / (distance_squared * cosine * cosine * cosine * pixel_area);
  // That was for areas of camera space, as seen along the ray: volumes scale by the product of the axes'
  // lengths, and the ray takes its own part of that.
  const Float volume = length(axis(0)) * length(axis(1)) * unit_of_depth;
  result.importance *= length(transform_vector(pose, to_point)) / (sqrt(distance_squared) * volume);
  result.depth = p.z * unit_of_depth;
  result.valid = in_front;
  if (camera.far_clip > 0) result.valid &= result.depth <= camera.far_clip;
  return result;
}

Vec3 normal_in_camera(const CameraRecord& camera, Vec3 normal, Float time) {
  const Vec3 n = transform_normal(pose_at(camera, time), normal);
  return n * (1.0f / sqrt(max(length_squared(n), 1e-30f)));
}

Float pixel_width(const CameraRecord& camera, Float distance) {
  const float step = std::max(std::abs(camera.scale_x), std::abs(camera.scale_y));
  switch (camera.kind) {
    case CameraKind::kOrthographic:
      return length(transform_vector(camera.render_from_camera, {Float(step), Float(0.0f), Float(0.0f)}));
    case CameraKind::kEquirectangular:
      return distance * (2 * kPi * step);
    case CameraKind::kOctahedral:
      return distance * (2 * std::sqrt(kPi) * step);  // the square is mapped evenly: 4 pi steradians
    default:
      return distance * step;
  }
}

Float visible_distance(const CameraRecord& camera, Vec3 direction, Float time) {
  return (camera.far_clip - camera.near_clip) * length_per_depth(camera, pose_at(camera, time), direction);
}

}  // namespace tessera::render::TESSERA_ISA
