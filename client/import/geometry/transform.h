// Transformations of scene files: Imath's matrices, in double precision.
//
// They multiply row vectors from the right, as pbrt's files hold them: in a product, the left factor acts
// first.
#pragma once

#include <ImathMatrix.h>
#include <ImathVec.h>

#include <array>
#include <optional>
#include <vector>

#include "tessera/v1/scene.pb.h"

namespace tessera::client {

/// The point that `transform` makes of `point` is point * transform; of a vector, without the translation, it
/// is this.
Imath::V3d transformed_vector(const Imath::V3d& vector, const Imath::M44d& transform);

/// Length that neither over- nor underflows; Imath's loses digits of numbers below 1e-154.
double length(const Imath::V3d& v);

/// Appends x, y and z.
void append_floats(std::vector<float>& out, const Imath::V3d& v);

/// Determinant of the upper left 3x3 part: the change of volume, negative where handedness changes.
double determinant3(const Imath::M44d& t);
bool is_finite(const Imath::M44d& t);
/// Nothing for a singular matrix. Unlike Imath's, which gives the identity then, and without its exceptions.
std::optional<Imath::M44d> inverse(const Imath::M44d& t);

Imath::M44d translation(double x, double y, double z);
Imath::M44d scaling(double x, double y, double z);
/// Counter-clockwise about `axis` (any length but zero) for an observer towards whom the axis points.
Imath::M44d rotation(double degrees, const Imath::V3d& axis);
/// camera_from_world for a camera at `eye`; x right, y up, z forward, left-handed. Nothing where eye and
/// target coincide or `up` is parallel to the view.
std::optional<Imath::M44d> look_at(const Imath::V3d& eye, const Imath::V3d& target, const Imath::V3d& up);

/// Pair of transforms that `ActiveTransform` keeps apart: where something is at the two times of
/// `TransformTimes`.
struct MovingTransform {
  Imath::M44d start, end;
  // When it begins and ends to move, 0 and 1 being the times between which the shutter is open.
  double begins = 0, ends = 1;

  bool moves() const { return !(start == end); }
  bool operator==(const MovingTransform&) const = default;
};

/// The matrix at time `t` between `t_start` and `t_end`, element by element; held outside of them.
Imath::M44d interpolated(const MovingTransform& moving, double t, double t_start, double t_end);

/// In the order of v1::Matrix, which multiplies column vectors from the left.
std::array<double, 16> elements_of(const Imath::M44d& t);
void write_matrix(const Imath::M44d& t, v1::Matrix& matrix);
/// The identity for a message that is empty, or no matrix.
Imath::M44d matrix_of(const v1::Matrix& message);
/// All 16 elements, also of the identity: for fields where empty means something else.
void write_all_elements(const Imath::M44d& t, v1::Matrix& matrix);

}  // namespace tessera::client
