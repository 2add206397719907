#include "import/geometry/transform.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace tessera::client {

using Imath::M44d;
using Imath::V3d;

namespace {

V3d normalized(const V3d& v) { return v / length(v); }

}  // namespace

V3d transformed_vector(const V3d& vector, const M44d& transform) {
  V3d result;
  transform.multDirMatrix(vector, result);
  return result;
}

double length(const V3d& v) { return std::hypot(v.x, v.y, v.z); }

void append_floats(std::vector<float>& out, const V3d& v) {
  for (const double x : {v.x, v.y, v.z}) out.push_back(static_cast<float>(x));
}

double determinant3(const M44d& t) {
  return t[0][0] * (t[1][1] * t[2][2] - t[2][1] * t[1][2]) -
         t[1][0] * (t[0][1] * t[2][2] - t[2][1] * t[0][2]) +
         t[2][0] * (t[0][1] * t[1][2] - t[1][1] * t[0][2]);
}

bool is_finite(const M44d& t) {
  return std::all_of(t.getValue(), t.getValue() + 16, [](double x) { return std::isfinite(x); });
}

std::optional<M44d> inverse(const M44d& t) {
  // Gauss-Jordan elimination with partial pivoting, of the matrix that acts on column vectors.
  M44d a = t.transposed(), result;
  for (int column = 0; column < 4; ++column) {
    int pivot = column;
    for (int r = column + 1; r < 4; ++r) {
      if (std::abs(a[r][column]) > std::abs(a[pivot][column])) pivot = r;
    }
    if (a[pivot][column] == 0 || !std::isfinite(a[pivot][column])) return std::nullopt;
    for (int c = 0; c < 4; ++c) {
      std::swap(a[pivot][c], a[column][c]);
      std::swap(result[pivot][c], result[column][c]);
    }
    const double scale = 1 / a[column][column];
    for (int c = 0; c < 4; ++c) {
      a[column][c] *= scale;
      result[column][c] *= scale;
    }
    for (int r = 0; r < 4; ++r) {
      if (r == column) continue;
      const double factor = a[r][column];
      for (int c = 0; c < 4; ++c) {
        a[r][c] -= factor * a[column][c];
        result[r][c] -= factor * result[column][c];
      }
    }
  }
  return is_finite(result) ? std::optional(result.transposed()) : std::nullopt;
}

M44d translation(double x, double y, double z) { return M44d().setTranslation(V3d(x, y, z)); }

M44d scaling(double x, double y, double z) { return M44d().setScale(V3d(x, y, z)); }

M44d rotation(double degrees, const V3d& axis) {
  // Rodrigues' formula.
  const V3d a = normalized(axis);
  const double radians = degrees * std::numbers::pi / 180;
  const double s = std::sin(radians), c = std::cos(radians);
  M44d t;
  for (int r = 0; r < 3; ++r) {
    for (int k = 0; k < 3; ++k) t[k][r] = a[r] * a[k] * (1 - c) + (r == k ? c : 0);
  }
  t[1][0] -= a.z * s;
  t[2][0] += a.y * s;
  t[0][1] += a.z * s;
  t[2][1] -= a.x * s;
  t[0][2] -= a.y * s;
  t[1][2] += a.x * s;
  return t;
}

std::optional<M44d> look_at(const V3d& eye, const V3d& target, const V3d& up) {
  const V3d view = target - eye;
  if (length(view) == 0 || length(up) == 0) return std::nullopt;
  const V3d forward = normalized(view);
  const V3d side = normalized(up).cross(forward);
  if (length(side) == 0) return std::nullopt;
  const V3d right = normalized(side);
  const V3d true_up = forward.cross(right);
  M44d world_from_camera;
  for (int i = 0; i < 3; ++i) {
    world_from_camera[0][i] = right[i];
    world_from_camera[1][i] = true_up[i];
    world_from_camera[2][i] = forward[i];
    world_from_camera[3][i] = eye[i];
  }
  return inverse(world_from_camera);
}

M44d interpolated(const MovingTransform& moving, double t, double t_start, double t_end) {
  if (t <= t_start || !moving.moves()) return moving.start;
  if (t >= t_end) return moving.end;
  const double x = (t - t_start) / (t_end - t_start);
  M44d result;
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) result[r][c] = (1 - x) * moving.start[r][c] + x * moving.end[r][c];
  }
  return result;
}

std::array<double, 16> elements_of(const M44d& t) {
  const M44d columns = t.transposed();
  std::array<double, 16> elements;
  std::copy_n(columns.getValue(), 16, elements.begin());
  return elements;
}

void write_matrix(const M44d& t, v1::Matrix& matrix) {
  matrix.clear_elements();
  if (t == M44d()) return;  // empty means identity
  write_all_elements(t, matrix);
}

Imath::M44d matrix_of(const v1::Matrix& message) {
  M44d columns;
  if (message.elements_size() == 16) std::copy_n(message.elements().begin(), 16, columns.getValue());
  return columns.transposed();
}

void write_all_elements(const M44d& t, v1::Matrix& matrix) {
  matrix.clear_elements();
  for (const double element : elements_of(t)) matrix.add_elements(element);
}

}  // namespace tessera::client
