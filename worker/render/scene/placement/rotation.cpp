#include "render/scene/placement/rotation.h"

#include <algorithm>
#include <cmath>

namespace tessera::render {

namespace {

/// Columns are the cofactors' rows: the inverse transposed, times the determinant.
Matrix3 cofactors(const Matrix3& m) {
  return {m[4] * m[8] - m[5] * m[7], m[5] * m[6] - m[3] * m[8], m[3] * m[7] - m[4] * m[6],
          m[2] * m[7] - m[1] * m[8], m[0] * m[8] - m[2] * m[6], m[1] * m[6] - m[0] * m[7],
          m[1] * m[5] - m[2] * m[4], m[2] * m[3] - m[0] * m[5], m[0] * m[4] - m[1] * m[3]};
}

double determinant(const Matrix3& m) {
  const Matrix3 c = cofactors(m);
  return m[0] * c[0] + m[1] * c[1] + m[2] * c[2];
}

}  // namespace

Matrix3 linear_part(const Transform& t) {
  return {t.m[0], t.m[1], t.m[2], t.m[4], t.m[5], t.m[6], t.m[8], t.m[9], t.m[10]};
}

Matrix3 product(const Matrix3& a, const Matrix3& b) {
  Matrix3 r;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j)
      r[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
  }
  return r;
}

Matrix3 transposed(const Matrix3& m) { return {m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]}; }

double norm(const Matrix3& m) {
  double sum = 0;
  for (const double x : m) sum += x * x;
  return std::sqrt(sum);
}

Matrix3 difference(const Matrix3& a, const Matrix3& b) {
  Matrix3 r;
  for (std::size_t i = 0; i < 9; ++i) r[i] = a[i] - b[i];
  return r;
}

std::optional<Matrix3> orthogonal_factor(const Matrix3& m) {
  // Scaled to unit size, so that no square over- or underflows.
  const double size = norm(m);
  if (!(size > 0) || !std::isfinite(size)) return std::nullopt;
  Matrix3 q;
  for (std::size_t i = 0; i < 9; ++i) q[i] = m[i] / size;
  constexpr int kMostSteps = 100;
  for (int step = 0; step < kMostSteps; ++step) {
    const double d = determinant(q);
    if (!(std::abs(d) > 0)) return std::nullopt;
    const double scale = 1 / std::cbrt(std::abs(d));
    const Matrix3 c = cofactors(q);
    Matrix3 next;
    for (std::size_t i = 0; i < 9; ++i) next[i] = 0.5 * (scale * q[i] + c[i] / (d * scale));
    const double change = norm(difference(next, q));
    if (!std::isfinite(change)) return std::nullopt;
    q = next;
    if (change < 1e-15) break;
  }
  // Where it did not converge, rounding has eaten the smallest of the stretches.
  const Matrix3 unit = product(q, transposed(q));
  if (norm(difference(unit, {1, 0, 0, 0, 1, 0, 0, 0, 1})) > 1e-9) return std::nullopt;
  return q;
}

Quaternion from_rotation(const Matrix3& r) {
  // The largest of the four components first [Shepperd 1978].
  const double trace = r[0] + r[4] + r[8];
  const double squares[4] = {trace, r[0], r[4], r[8]};
  const auto largest = std::max_element(squares, squares + 4) - squares;
  Quaternion q;
  switch (largest) {
    case 0:
      q = {1 + trace, r[7] - r[5], r[2] - r[6], r[3] - r[1]};
      break;
    case 1:
      q = {r[7] - r[5], 1 + r[0] - r[4] - r[8], r[1] + r[3], r[2] + r[6]};
      break;
    case 2:
      q = {r[2] - r[6], r[1] + r[3], 1 - r[0] + r[4] - r[8], r[5] + r[7]};
      break;
    default:
      q = {r[3] - r[1], r[2] + r[6], r[5] + r[7], 1 - r[0] - r[4] + r[8]};
      break;
  }
  const double l = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {q.w / l, q.x / l, q.y / l, q.z / l};
}

Matrix3 to_rotation(const Quaternion& q) {
  const double xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z, xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
  const double wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  return {1 - 2 * (yy + zz), 2 * (xy - wz), 2 * (xz + wy), 2 * (xy + wz),    1 - 2 * (xx + zz),
          2 * (yz - wx),     2 * (xz - wy), 2 * (yz + wx), 1 - 2 * (xx + yy)};
}

Matrix3 rotation_about(const Imath::V3d& axis, double radians) {
  const double half = radians / 2, s = std::sin(half);
  return to_rotation({std::cos(half), s * axis.x, s * axis.y, s * axis.z});
}

double angle_between(const Quaternion& a, const Quaternion& b) {
  const auto size = [](double w, double x, double y, double z) {
    return std::sqrt(w * w + x * x + y * y + z * z);
  };
  return 2 * std::atan2(size(a.w - b.w, a.x - b.x, a.y - b.y, a.z - b.z),
                        size(a.w + b.w, a.x + b.x, a.y + b.y, a.z + b.z));
}

Quaternion slerp(double t, const Quaternion& a, const Quaternion& b) {
  const double angle = angle_between(a, b);
  double from = 1 - t, to = t;
  if (angle > 1e-7) {
    from = std::sin((1 - t) * angle) / std::sin(angle);
    to = std::sin(t * angle) / std::sin(angle);
  }
  const Quaternion q{from * a.w + to * b.w, from * a.x + to * b.x, from * a.y + to * b.y,
                     from * a.z + to * b.z};
  const double l = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {q.w / l, q.x / l, q.y / l, q.z / l};
}

}  // namespace tessera::render
