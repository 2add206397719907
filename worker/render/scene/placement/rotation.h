// Rotations as quaternions, and the parts that a linear map has.
#pragma once

#include <array>
#include <optional>

#include "render/scene/placement/transform.h"

namespace tessera::render {

/// Rows; acts on column vectors.
using Matrix3 = std::array<double, 9>;

/// Unit quaternion.
struct Quaternion {
  double w = 1, x = 0, y = 0, z = 0;
};

Matrix3 linear_part(const Transform& t);
Matrix3 product(const Matrix3& a, const Matrix3& b);
Matrix3 transposed(const Matrix3& m);
Matrix3 difference(const Matrix3& a, const Matrix3& b);
/// Frobenius norm.
double norm(const Matrix3& m);

/// The orthogonal matrix nearest to `m`, by Newton's iteration with scaling [Higham 1986]; its determinant
/// has the sign of m's. None for matrices that are singular to working precision.
std::optional<Matrix3> orthogonal_factor(const Matrix3& m);

Quaternion from_rotation(const Matrix3& r);
Matrix3 to_rotation(const Quaternion& q);
/// The rotation by `radians` about a unit axis, right-handed.
Matrix3 rotation_about(const Imath::V3d& axis, double radians);
/// Half the angle of the rotation that leads from one to the other, the way that keeps the signs.
double angle_between(const Quaternion& a, const Quaternion& b);
Quaternion slerp(double t, const Quaternion& a, const Quaternion& b);

}  // namespace tessera::render
