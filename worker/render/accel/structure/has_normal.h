// Which triangles have an area that shading can use, for those who build structures and for those who meet
// what deforms in them.
#pragma once

#include <algorithm>
#include <cmath>

namespace tessera::render {

/// Whether the normal that shading computes of a triangle (shape/triangle_normal.h) exists.
inline bool has_normal(const float (&corners)[3][3]) {
  // Computed as shading does, in float, after the sides are brought to size 1 by a power of two.
  float e1[3], e2[3], size = 0;
  for (int k = 0; k < 3; ++k) {
    e1[k] = corners[1][k] - corners[0][k], e2[k] = corners[2][k] - corners[0][k];
    size = std::max({size, std::abs(e1[k]), std::abs(e2[k])});
  }
  if (!(size > 0) || !std::isfinite(size)) return false;
  const int exponent = -std::ilogb(size);
  for (int k = 0; k < 3; ++k) e1[k] = std::scalbn(e1[k], exponent), e2[k] = std::scalbn(e2[k], exponent);
  float squared = 0;
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const float n = e1[i] * e2[j] - e1[j] * e2[i];
    squared += n * n;
  }
  return squared > 0 && std::isfinite(squared);
}

}  // namespace tessera::render
