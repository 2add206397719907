// Motion of a shape, an instance or the camera while the shutter is open.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "absl/status/statusor.h"
#include "render/scene/placement/transform.h"

namespace tessera::render {

/// The way from one placement to another, by translation, rotation and stretch at constant speeds each: M = T
/// R S, R orthogonal and S symmetric [Shoemake & Duff 1992]. Rotations take the shorter way round.
class Motion {
 public:
  /// Stands still.
  explicit Motion(const Transform& place) : start_(place) {}
  /// InvalidArgument when a placement is singular, or one the other's mirror image: some placement in between
  /// would be flat.
  static absl::StatusOr<Motion> between(const Transform& start, const Transform& end);
  /// The same of messages, with the errors of Transform::from_proto(); stands still where `end` is empty.
  static absl::StatusOr<Motion> from_proto(const v1::Matrix& start, const v1::Matrix& end);

  bool moves() const { return segments_ > 0; }
  /// Time 0 is when the shutter opens, 1 when it closes.
  Transform at(double time) const;
  /// How many pieces, with linear interpolation of the matrix in each, keep points within 1e-5 of the way, as
  /// a fraction of their distance from the origin of the space that is placed; at most kMostSegments, which
  /// is enough for rotations of up to 65 degrees (half a turn: 7.5e-5). 0: it stands still.
  int segments() const { return segments_; }
  /// Whether it moves along a straight line without turning or stretching.
  bool translates_only() const;

  static constexpr int kMostSegments = 128;  // Embree's limit

 private:
  struct Quaternion {
    double w = 1, x = 0, y = 0, z = 0;
  };
  using Matrix3 = std::array<double, 9>;

  void count_segments();
  static Quaternion from_rotation(const Matrix3& r);
  static Matrix3 to_rotation(const Quaternion& q);
  static Quaternion slerp(double t, const Quaternion& a, const Quaternion& b);
  static double angle_between(const Quaternion& a, const Quaternion& b);

  Transform start_, end_;
  Quaternion rotations_[2];
  Matrix3 stretches_[2] = {};
  int segments_ = 0;
};

/// The segments that the product of two motions needs.
int segments_of_product(const Motion& left, const Motion& right);

/// `place` at segments + 1 evenly spaced times in [0, 1], appended. InvalidArgument when one is not finite.
absl::Status append_steps(const std::function<Transform(double)>& place, int segments,
                          std::vector<Affine>& steps);

}  // namespace tessera::render
