// 4x4 affine maps in double precision, for loading scenes.
#pragma once

#include <ImathVec.h>

#include <array>

#include "absl/status/statusor.h"
#include "render/core/affine_data.h"

namespace tessera::v1 {
class Matrix;
}

namespace tessera::render {

/// Rows; acts on column vectors. The last row is (0, 0, 0, 1).
struct Transform {
  std::array<double, 12> m = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

  Imath::V3d apply(Imath::V3d p) const;         // maps a point
  Imath::V3d apply_vector(Imath::V3d v) const;  // maps a vector: no translation
  double determinant() const;
  /// False when the map is singular (or not finite); `out` is then unchanged.
  bool invert(Transform& out) const;
  Transform operator*(const Transform& right) const;
  Affine to_affine() const;

  static Transform translation(Imath::V3d by);
  /// Identity for an empty matrix. InvalidArgument for one that has not 16 finite elements or is not affine.
  static absl::StatusOr<Transform> from_proto(const v1::Matrix& matrix);
};

/// Whether 32-bit floats can do with a map and its inverse: squares of their elements are finite, and so are
/// both determinants, which are not rounded to zero either.
bool fits_floats(const Transform& map, const Transform& inverse);
/// The error where they cannot.
inline constexpr const char* kBeyondFloats =
    "its transform scales by more, or by less, than 32-bit floats hold";
/// The most that a map makes of the length of an axis.
double largest_scale(const Affine& map);

}  // namespace tessera::render
