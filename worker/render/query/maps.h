// Points and affine maps in double precision, as queries use them.
#pragma once

#include <ImathVec.h>

#include "render/shape/exact_affine.h"

namespace tessera::render {

using Imath::V3d;

inline V3d apply(const ExactAffine& a, const V3d& p) {
  const double* const m = a.m;
  return {m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
          m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]};
}

/// `outer` after `inner`.
inline ExactAffine compose(const ExactAffine& outer, const ExactAffine& inner) {
  ExactAffine all;
  for (int i = 0; i < 3; ++i) {
    const double* const row = outer.m + 4 * i;
    for (int j = 0; j < 4; ++j) {
      all.m[4 * i + j] = row[0] * inner.m[j] + row[1] * inner.m[4 + j] + row[2] * inner.m[8 + j];
    }
    all.m[4 * i + 3] += row[3];
  }
  return all;
}

inline V3d to_point(const float (&p)[3]) { return {p[0], p[1], p[2]}; }

}  // namespace tessera::render
