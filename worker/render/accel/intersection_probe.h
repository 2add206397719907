// How far the fast ray-triangle tests may be trusted with a scene, told from its geometry before anything is
// built.
#pragma once

#include <cstdint>

namespace tessera::render {

struct ShapeTable;

/// Findings in a sample of the scene's surfaces; the same wherever it is taken. Shares are of the solid
/// angles that surfaces would fill seen from the camera, each for itself.
struct IntersectionProbe {
  /// Part of the rays to a surface that fast tests are expected to let through, by rounding, at edges and
  /// where boxes are missed.
  double leak = 0;
  /// The same of the shape that leaks most, and of the border of media that does. Indices in
  /// ShapeTable::shapes; -1: nothing leaks.
  double shape_leak = 0, border_leak = 0;
  std::int32_t leaking_shape = -1, leaking_border = -1;
  /// Part of the surfaces that are too fine for floats: features smaller than kFinest of their distance. And
  /// the shape with most of them.
  double too_fine = 0;
  std::int32_t finest_shape = -1;

  /// With a tenfold contrast between what a ray should meet and what is behind, an error of 0.1 % of the
  /// mean.
  static constexpr double kSafeLeak = 1e-4;
  static constexpr double kSafeShapeLeak = 1e-2;
  /// A path that misses the border of a medium is on the wrong side of it to its end.
  static constexpr double kSafeBorderLeak = 1e-6;
  /// Offset rays start about half of that away (shape/error_bound.h).
  static constexpr double kFinest = 1e-6;

  bool wants_robust() const {
    return leak > kSafeLeak || shape_leak > kSafeShapeLeak || border_leak > kSafeBorderLeak;
  }
};

/// Looks at up to 2^16 triangles, evenly over shapes and then over triangles. Degenerate ones, which no ray
/// meets, do not count.
IntersectionProbe probe_intersection(const ShapeTable& shapes);

}  // namespace tessera::render
