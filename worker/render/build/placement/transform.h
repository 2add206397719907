// 4x4 affine maps in double precision, for loading scenes.
#pragma once

#include <array>

#include "absl/status/statusor.h"
#include "render/core/affine_data.h"

namespace tessera::v1 {
class Matrix;
}

namespace tessera::render {

struct Point {
  double x = 0, y = 0, z = 0;
};

/// Rows; acts on column vectors. The last row is (0, 0, 0, 1).
struct Transform {
  std::array<double, 12> m = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

  Point apply(Point p) const;         // to a point
  Point apply_vector(Point v) const;  // without the translation
  double determinant() const;
  /// False when the map is singular (or not finite); `out` is then unchanged.
  bool invert(Transform& out) const;
  Transform operator*(const Transform& right) const;
  Affine to_affine() const;

  static Transform translation(Point by);
  /// Identity for an empty matrix. InvalidArgument for one that has not 16 finite elements or is not affine.
  static absl::StatusOr<Transform> from_proto(const v1::Matrix& matrix);
};

/// Whether 32-bit floats can do with a map and its inverse: squares of their elements are finite, and so are
/// both determinants, which are not rounded to zero either.
bool fits_floats(const Transform& map, const Transform& inverse);
/// The error where they cannot.
inline constexpr const char* kBeyondFloats =
    "its transform scales by more, or by less, than 32-bit floats hold";

Point operator-(Point a, Point b);
Point cross(Point a, Point b);
double dot(Point a, Point b);
double length(Point a);

}  // namespace tessera::render
