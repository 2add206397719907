// 4x4 matrices in double precision, as the transformations of scene files make them.
#pragma once

#include <array>
#include <optional>

#include "tessera/v1/scene.pb.h"

namespace tessera::client {

using Vector3 = std::array<double, 3>;

/// Row-major, acting on column vectors. A product a * b applies b first.
struct Transform {
  std::array<double, 16> m = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

  double operator()(int row, int column) const { return m[4 * row + column]; }
  double& operator()(int row, int column) { return m[4 * row + column]; }
  bool operator==(const Transform&) const = default;

  Vector3 apply_to_point(const Vector3& p) const;
  Vector3 apply_to_vector(const Vector3& v) const;
  /// Determinant of the upper left 3x3 part: the change of volume, negative where handedness changes.
  double determinant3() const;
  bool is_finite() const;
};

Transform operator*(const Transform& a, const Transform& b);
/// Nothing for a singular matrix.
std::optional<Transform> inverse(const Transform& t);
Transform transposed(const Transform& t);

Transform translation(double x, double y, double z);
Transform scaling(double x, double y, double z);
/// Counter-clockwise about `axis` (any length but zero) for an observer towards whom the axis points.
Transform rotation(double degrees, const Vector3& axis);
/// camera_from_world for a camera at `eye`; x right, y up, z forward, left-handed. Nothing where eye and
/// target coincide or `up` is parallel to the view.
std::optional<Transform> look_at(const Vector3& eye, const Vector3& target, const Vector3& up);

/// Pair of transforms that `ActiveTransform` keeps apart: where something is at the two times of
/// `TransformTimes`.
struct MovingTransform {
  Transform start, end;

  bool moves() const { return !(start == end); }
  bool operator==(const MovingTransform&) const = default;
};

/// The matrix at time `t` between `t_start` and `t_end`, element by element; held outside of them.
Transform interpolated(const MovingTransform& moving, double t, double t_start, double t_end);

void write_matrix(const Transform& t, v1::Matrix& matrix);
/// All 16 elements, also of the identity: for fields where empty means something else.
void write_all_elements(const Transform& t, v1::Matrix& matrix);

}  // namespace tessera::client
