#include "light_field/pinhole.h"

#include <cmath>

namespace tessera::light_field {

Imath::V3d transformed_vector(const Matrix4& m, const Imath::V3d& v) {
  return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[4] * v.x + m[5] * v.y + m[6] * v.z,
          m[8] * v.x + m[9] * v.y + m[10] * v.z};
}

Imath::V3d transformed_point(const Matrix4& m, const Imath::V3d& p) {
  return transformed_vector(m, p) + Imath::V3d(m[3], m[7], m[11]);
}

Imath::V3d Pinhole::direction(double x, double y) const {
  return transformed_vector(world_from_camera, {(x - cx) / fx, (cy - y) / fy, 1});
}

void set_window(const ImageWindow& window, double width, double height, Pinhole& camera) {
  camera.fx = width / (window.x1 - window.x0);
  camera.fy = height / (window.y1 - window.y0);
  camera.cx = -window.x0 * camera.fx;
  camera.cy = window.y1 * camera.fy;
}

ImageWindow window_of(const Pinhole& camera, double width, double height) {
  return {-camera.cx / camera.fx, (width - camera.cx) / camera.fx, (camera.cy - height) / camera.fy,
          camera.cy / camera.fy};
}

std::optional<Matrix4> inverse(const Matrix4& m) {
  const Imath::V3d x(m[0], m[4], m[8]), y(m[1], m[5], m[9]), z(m[2], m[6], m[10]), place(m[3], m[7], m[11]);
  const double determinant = x.dot(y.cross(z));
  if (!std::isfinite(1 / determinant) || !std::isfinite(place.x + place.y + place.z)) return std::nullopt;
  const Imath::V3d rows[] = {y.cross(z) / determinant, z.cross(x) / determinant, x.cross(y) / determinant};
  Matrix4 result{};
  for (std::size_t r = 0; r < 3; ++r) {
    result[4 * r] = rows[r].x, result[4 * r + 1] = rows[r].y, result[4 * r + 2] = rows[r].z;
    result[4 * r + 3] = -rows[r].dot(place);
  }
  result[15] = 1;
  return result;
}

bool mirrors(const Matrix4& m) {
  const Imath::V3d x(m[0], m[4], m[8]), y(m[1], m[5], m[9]), z(m[2], m[6], m[10]);
  return x.dot(y.cross(z)) < 0;
}

Matrix4 looking(const Imath::V3d& place, const Imath::V3d& toward, const Imath::V3d& up, bool mirrored) {
  const Imath::V3d z = toward.normalized();
  Imath::V3d x = up.normalized().cross(z);
  // Up along the axis: any direction across it will do.
  if (x.length() < 1e-6) x = (std::abs(z.x) < 0.5 ? Imath::V3d(1, 0, 0) : Imath::V3d(0, 0, 1)).cross(z);
  x.normalize();
  const Imath::V3d y = z.cross(x);
  if (mirrored) x = -x;
  return {x.x, y.x, z.x, place.x, x.y, y.y, z.y, place.y, x.z, y.z, z.z, place.z, 0, 0, 0, 1};
}

Projection Projection::of(const Pinhole& camera, const Imath::V3d& origin) {
  const Matrix4 from_world = inverse(camera.world_from_camera).value();
  const Imath::V3d x(from_world[0], from_world[1], from_world[2]),
      y(from_world[4], from_world[5], from_world[6]), z(from_world[8], from_world[9], from_world[10]);
  const Imath::V3d there = transformed_point(from_world, origin);
  const auto put = [](const Imath::V3d& row, double shift, float(&to)[4]) {
    to[0] = static_cast<float>(row.x), to[1] = static_cast<float>(row.y), to[2] = static_cast<float>(row.z);
    to[3] = static_cast<float>(shift);
  };
  Projection projection;
  put(camera.fx * x + camera.cx * z, camera.fx * there.x + camera.cx * there.z, projection.rows[0]);
  put(camera.cy * z - camera.fy * y, camera.cy * there.z - camera.fy * there.y, projection.rows[1]);
  put(z, there.z, projection.rows[2]);
  return projection;
}

}  // namespace tessera::light_field
