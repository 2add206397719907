// Affine maps in double: a ray that is moved into an object's space and a box that is moved out of it are off
// by far less than boxes are padded by.
#pragma once

#include <algorithm>
#include <cmath>

#include "render/core/affine_data.h"
#include "render/shape/shape_table.h"

namespace tessera::render {

/// Rows of a 3x4 matrix.
struct ExactAffine {
  double m[12];
};

inline ExactAffine exact(const Affine& a) {
  ExactAffine result;
  std::copy_n(a.m, 12, result.m);
  return result;
}

/// Inverse of a map that is not singular; elements are not finite where it is.
inline ExactAffine inverse(const ExactAffine& a) {
  const double* const m = a.m;
  ExactAffine r;
  double determinant = 0;
  for (int i = 0; i < 3; ++i) {
    // Row i of the inverse: the cross product of the other two columns.
    const int p = (i + 1) % 3, q = (i + 2) % 3;
    for (int k = 0; k < 3; ++k) {
      const int y = (k + 1) % 3, z = (k + 2) % 3;
      r.m[4 * i + k] = m[4 * y + p] * m[4 * z + q] - m[4 * z + p] * m[4 * y + q];
    }
  }
  for (int k = 0; k < 3; ++k) determinant += r.m[k] * m[4 * k];
  for (int i = 0; i < 3; ++i) {
    double* const row = r.m + 4 * i;
    for (int k = 0; k < 3; ++k) row[k] /= determinant;
    row[3] = -(row[0] * m[3] + row[1] * m[7] + row[2] * m[11]);
  }
  return r;
}

/// First `b`, then `a`.
inline ExactAffine product(const ExactAffine& a, const ExactAffine& b) {
  ExactAffine r;
  for (int i = 0; i < 3; ++i) {
    const double* const row = a.m + 4 * i;
    for (int k = 0; k < 4; ++k) r.m[4 * i + k] = row[0] * b.m[k] + row[1] * b.m[4 + k] + row[2] * b.m[8 + k];
    r.m[4 * i + 3] += row[3];
  }
  return r;
}

/// Map of an instance at `time`, from 0 to 1: elements are linear between its steps, as core/motion.h has it.
inline ExactAffine placement_at(const ShapeTable& table, const InstanceRecord& instance, float time) {
  if (instance.segments == 0) return exact(instance.render_from_instance);
  const float place = time * static_cast<float>(instance.segments);
  const std::int32_t before = std::clamp(static_cast<std::int32_t>(place), 0, instance.segments - 1);
  const double after_part = double{place} - before;
  const Affine* const step = table.motion_steps.data() + instance.first_step + before;
  ExactAffine map;
  for (int i = 0; i < 12; ++i) map.m[i] = (1 - after_part) * step[0].m[i] + after_part * step[1].m[i];
  return map;
}

}  // namespace tessera::render
