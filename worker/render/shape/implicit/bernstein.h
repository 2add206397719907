// Polynomials on [-1, 1] in the basis of Bernstein.
#pragma once

#include "render/shape/implicit/ray_polynomial.h"

namespace tessera::render::TESSERA_ISA {

/// table[n][m][k]: coefficient k of s^m in the basis of degree n. None is larger than 1.
struct BernsteinTable {
  double of[kMaxRayDegree + 1][kMaxRayDegree + 1][kMaxRayDegree + 1];
};
const BernsteinTable& bernstein_table();

}  // namespace tessera::render::TESSERA_ISA
