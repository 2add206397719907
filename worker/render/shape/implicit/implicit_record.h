// Implicit surfaces as the kernels read them: filled by scene/shape/implicit.cpp.
#pragma once

#include <cstdint>
#include <vector>

#include "expression/program.h"
#include "render/core/affine_data.h"

namespace tessera::render {

enum class ImplicitRoots : std::int32_t { kSturm, kInterval, kNewton, kSphereTracing };

/// The zero set of a function of object space within a box or a sphere.
struct ImplicitRecord {
  Affine render_from_object;
  Affine object_from_render;
  float low[3] = {-1, -1, -1}, high[3] = {1, 1, 1};  // the box, or the box about the sphere
  std::int32_t in_sphere = 0;
  float centre[3] = {0, 0, 0};
  float radius = 1;

  expression::Program program;
  ImplicitRoots roots = ImplicitRoots::kInterval;
  double lipschitz = 0;  // kSphereTracing: largest |f(p) - f(q)| / |p - q|

  // kInterval, other than polynomials: cells of the bounds along each axis, 0 for none; a bit for each cell
  // that the surface may cross, x first, then y, then z (mark_cells.h).
  std::int32_t cells = 0;
  std::vector<std::uint64_t> marked;

  // A polynomial's degree; 0 for other functions.
  std::int32_t degree = 0;
  // Coefficients for Horner's rule in x, y and z, from the highest powers down: for i, for j up to degree -
  // i, for k up to degree - i - j.
  std::vector<double> coefficients;
  // Bounds over the box: the sum of the absolute values of all terms, and of those of all terms' derivatives.
  double magnitude = 0, slope = 0;
};

}  // namespace tessera::render
