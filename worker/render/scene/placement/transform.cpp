#include "render/scene/placement/transform.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

Imath::V3d Transform::apply(Imath::V3d p) const {
  const Imath::V3d v = apply_vector(p);
  return {v.x + m[3], v.y + m[7], v.z + m[11]};
}

Imath::V3d Transform::apply_vector(Imath::V3d v) const {
  return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[4] * v.x + m[5] * v.y + m[6] * v.z,
          m[8] * v.x + m[9] * v.y + m[10] * v.z};
}

double Transform::determinant() const {
  return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
         m[2] * (m[4] * m[9] - m[5] * m[8]);
}

bool Transform::invert(Transform& out) const {
  const double d = determinant();
  if (d == 0 || !std::isfinite(d) || !std::isfinite(1 / d)) return false;
  Transform r;
  r.m[0] = (m[5] * m[10] - m[6] * m[9]) / d;
  r.m[1] = (m[2] * m[9] - m[1] * m[10]) / d;
  r.m[2] = (m[1] * m[6] - m[2] * m[5]) / d;
  r.m[4] = (m[6] * m[8] - m[4] * m[10]) / d;
  r.m[5] = (m[0] * m[10] - m[2] * m[8]) / d;
  r.m[6] = (m[2] * m[4] - m[0] * m[6]) / d;
  r.m[8] = (m[4] * m[9] - m[5] * m[8]) / d;
  r.m[9] = (m[1] * m[8] - m[0] * m[9]) / d;
  r.m[10] = (m[0] * m[5] - m[1] * m[4]) / d;
  const Imath::V3d t = r.apply_vector({m[3], m[7], m[11]});
  r.m[3] = -t.x, r.m[7] = -t.y, r.m[11] = -t.z;
  if (!std::all_of(r.m.begin(), r.m.end(), [](double x) { return std::isfinite(x); })) return false;
  out = r;
  return true;
}

bool fits_floats(const Transform& map, const Transform& inverse) {
  constexpr double kLargest = 1e18, kLargestVolume = 1e36;  // its inverse is still a normal number
  for (const Transform* t : {&map, &inverse}) {
    for (const double x : t->m) {
      if (!(std::abs(x) <= kLargest)) return false;
    }
    if (!(std::abs(t->determinant()) <= kLargestVolume)) return false;
  }
  return true;
}

Transform Transform::operator*(const Transform& right) const {
  Transform r;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 4; ++j) {
      r.m[4 * i + j] = m[4 * i] * right.m[j] + m[4 * i + 1] * right.m[4 + j] + m[4 * i + 2] * right.m[8 + j] +
                       (j == 3 ? m[4 * i + 3] : 0.0);
    }
  }
  return r;
}

Affine Transform::to_affine() const {
  Affine a;
  std::transform(m.begin(), m.end(), a.m, [](double x) { return static_cast<float>(x); });
  return a;
}

Transform Transform::translation(Imath::V3d by) {
  Transform t;
  t.m[3] = by.x, t.m[7] = by.y, t.m[11] = by.z;
  return t;
}

absl::StatusOr<Transform> Transform::from_proto(const v1::Matrix& matrix) {
  if (matrix.elements().empty()) return Transform{};
  if (matrix.elements_size() != 16) {
    return absl::InvalidArgumentError(
        absl::StrCat("a matrix has ", matrix.elements_size(), " elements instead of 16"));
  }
  const auto& e = matrix.elements();
  if (!std::all_of(e.begin(), e.end(), [](double x) { return std::isfinite(x); })) {
    return absl::InvalidArgumentError("a matrix has an element that is not finite");
  }
  if (e[12] != 0 || e[13] != 0 || e[14] != 0 || e[15] == 0) {
    return absl::InvalidArgumentError("a matrix is not affine: its last row must be 0 0 0 1");
  }
  Transform t;
  for (int i = 0; i < 12; ++i) t.m[i] = e[i] / e[15];
  return t;
}

double largest_scale(const Affine& map) {
  double largest = 0;
  for (int c = 0; c < 3; ++c)
    largest = std::max(largest, std::hypot(double{map.m[c]}, double{map.m[4 + c]}, double{map.m[8 + c]}));
  return largest;
}

}  // namespace tessera::render
