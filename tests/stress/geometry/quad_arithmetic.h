// Arithmetic of 113 bits, which holds all that floats give exactly but the square roots, and what shapes are
// judged by with it.
#pragma once

#include <cmath>

#include "render/core/affine_data.h"
#include "support/kernel/double_point.h"

namespace tessera::render::TESSERA_ISA {

#if defined(__SIZEOF_FLOAT128__)
using Quad = __float128;
#else
using Quad = long double;  // it has as many bits where there is no __float128
#endif

inline Quad root(Quad x) {
  if (x <= 0) return 0;
  Quad y = std::sqrt(static_cast<double>(x));
  for (int i = 0; i < 2; ++i) y = (y + x / y) / 2;
  return y;
}
inline double magnitude(Quad x) { return std::abs(static_cast<double>(x)); }

struct QuadPoint {
  Quad x, y, z;
};
inline QuadPoint along(const QuadPoint& o, const QuadPoint& d, Quad t) {
  return {o.x + d.x * t, o.y + d.y * t, o.z + d.z * t};
}

/// The map that a record holds, applied to what a ray holds.
inline QuadPoint placed(const Affine& a, test::Point p, int w) {
  const auto row = [&](int i) {
    return Quad(a.m[i]) * Quad(p.x) + Quad(a.m[i + 1]) * Quad(p.y) + Quad(a.m[i + 2]) * Quad(p.z) +
           Quad(a.m[i + 3]) * w;
  };
  return {row(0), row(4), row(8)};
}

constexpr double kUnit = 0x1p-24;  // half a unit in the last place of 1

/// The hit that a ray should have. `certain`: no decision on the way is closer than a float can tell.
struct Expected {
  bool hit = false, certain = true;
  double t = 0, tolerance = 0;
};

}  // namespace tessera::render::TESSERA_ISA
