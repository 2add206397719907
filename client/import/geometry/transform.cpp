#include "import/geometry/transform.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "import/geometry/vector3.h"

namespace tessera::client {
namespace {

Vector3 normalized(const Vector3& v) {
  const double l = length(v);
  return {v[0] / l, v[1] / l, v[2] / l};
}

}  // namespace

Vector3 Transform::apply_to_vector(const Vector3& v) const {
  Vector3 result;
  for (int r = 0; r < 3; ++r) result[r] = (*this)(r, 0) * v[0] + (*this)(r, 1) * v[1] + (*this)(r, 2) * v[2];
  return result;
}

Vector3 Transform::apply_to_point(const Vector3& p) const {
  Vector3 result = apply_to_vector(p);
  const double w = (*this)(3, 0) * p[0] + (*this)(3, 1) * p[1] + (*this)(3, 2) * p[2] + (*this)(3, 3);
  for (int r = 0; r < 3; ++r) result[r] = (result[r] + (*this)(r, 3)) / w;
  return result;
}

double Transform::determinant3() const {
  const Transform& t = *this;
  return t(0, 0) * (t(1, 1) * t(2, 2) - t(1, 2) * t(2, 1)) -
         t(0, 1) * (t(1, 0) * t(2, 2) - t(1, 2) * t(2, 0)) +
         t(0, 2) * (t(1, 0) * t(2, 1) - t(1, 1) * t(2, 0));
}

bool Transform::is_finite() const {
  return std::all_of(m.begin(), m.end(), [](double x) { return std::isfinite(x); });
}

Transform operator*(const Transform& a, const Transform& b) {
  Transform product;
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) {
      product(r, c) = a(r, 0) * b(0, c) + a(r, 1) * b(1, c) + a(r, 2) * b(2, c) + a(r, 3) * b(3, c);
    }
  }
  return product;
}

std::optional<Transform> inverse(const Transform& t) {
  // Gauss-Jordan elimination with partial pivoting.
  Transform a = t, result;
  for (int column = 0; column < 4; ++column) {
    int pivot = column;
    for (int r = column + 1; r < 4; ++r) {
      if (std::abs(a(r, column)) > std::abs(a(pivot, column))) pivot = r;
    }
    if (a(pivot, column) == 0 || !std::isfinite(a(pivot, column))) return std::nullopt;
    for (int c = 0; c < 4; ++c) {
      std::swap(a(pivot, c), a(column, c));
      std::swap(result(pivot, c), result(column, c));
    }
    const double scale = 1 / a(column, column);
    for (int c = 0; c < 4; ++c) {
      a(column, c) *= scale;
      result(column, c) *= scale;
    }
    for (int r = 0; r < 4; ++r) {
      if (r == column) continue;
      const double factor = a(r, column);
      for (int c = 0; c < 4; ++c) {
        a(r, c) -= factor * a(column, c);
        result(r, c) -= factor * result(column, c);
      }
    }
  }
  return result.is_finite() ? std::optional(result) : std::nullopt;
}

Transform transposed(const Transform& t) {
  Transform result;
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) result(r, c) = t(c, r);
  }
  return result;
}

Transform translation(double x, double y, double z) {
  Transform t;
  t(0, 3) = x;
  t(1, 3) = y;
  t(2, 3) = z;
  return t;
}

Transform scaling(double x, double y, double z) {
  Transform t;
  t(0, 0) = x;
  t(1, 1) = y;
  t(2, 2) = z;
  return t;
}

Transform rotation(double degrees, const Vector3& axis) {
  // Rodrigues' formula.
  const Vector3 a = normalized(axis);
  const double radians = degrees * std::numbers::pi / 180;
  const double s = std::sin(radians), c = std::cos(radians);
  Transform t;
  for (int r = 0; r < 3; ++r) {
    for (int k = 0; k < 3; ++k) t(r, k) = a[r] * a[k] * (1 - c) + (r == k ? c : 0);
  }
  t(0, 1) -= a[2] * s;
  t(0, 2) += a[1] * s;
  t(1, 0) += a[2] * s;
  t(1, 2) -= a[0] * s;
  t(2, 0) -= a[1] * s;
  t(2, 1) += a[0] * s;
  return t;
}

std::optional<Transform> look_at(const Vector3& eye, const Vector3& target, const Vector3& up) {
  const Vector3 view = {target[0] - eye[0], target[1] - eye[1], target[2] - eye[2]};
  if (length(view) == 0 || length(up) == 0) return std::nullopt;
  const Vector3 forward = normalized(view);
  const Vector3 side = cross(normalized(up), forward);
  if (length(side) == 0) return std::nullopt;
  const Vector3 right = normalized(side);
  const Vector3 true_up = cross(forward, right);
  Transform world_from_camera;
  for (int r = 0; r < 3; ++r) {
    world_from_camera(r, 0) = right[r];
    world_from_camera(r, 1) = true_up[r];
    world_from_camera(r, 2) = forward[r];
    world_from_camera(r, 3) = eye[r];
  }
  return inverse(world_from_camera);
}

Transform interpolated(const MovingTransform& moving, double t, double t_start, double t_end) {
  if (t <= t_start || !moving.moves()) return moving.start;
  if (t >= t_end) return moving.end;
  const double x = (t - t_start) / (t_end - t_start);
  Transform result;
  for (int i = 0; i < 16; ++i) result.m[i] = (1 - x) * moving.start.m[i] + x * moving.end.m[i];
  return result;
}

void write_matrix(const Transform& t, v1::Matrix& matrix) {
  matrix.clear_elements();
  if (t == Transform{}) return;  // empty means identity
  write_all_elements(t, matrix);
}

void write_all_elements(const Transform& t, v1::Matrix& matrix) {
  matrix.clear_elements();
  for (const double element : t.m) matrix.add_elements(element);
}

}  // namespace tessera::client
