// Shapes whose roots are found in double precision, from the compensated rays of object space (quadric.h).
#pragma once

#include <cstdint>

#include "render/shape/quadric.h"

namespace tessera::render::TESSERA_ISA {

/// Some of a wide value's lanes as doubles, as many as the machine has: a vector of GCC and Clang, with their
/// operators and with `mask ? a : b`.
inline constexpr int kDoubleWidth = kPartWidth / 2;
using Double = double __attribute__((vector_size(kDoubleWidth * sizeof(double))));
using DoubleMask = decltype(Double{} < Double{});
inline constexpr double kNoRoot = __builtin_inf();

TESSERA_INLINE Double splat(double x) { return Double{} + x; }
TESSERA_INLINE Double lower(Double a, Double b) { return a < b ? a : b; }
TESSERA_INLINE Double upper(Double a, Double b) { return a > b ? a : b; }
TESSERA_INLINE Double square_root(Double a) {
  for (int i = 0; i < kDoubleWidth; ++i) a[i] = __builtin_sqrt(a[i]);
  return a;
}
TESSERA_INLINE bool any_of(DoubleMask m) {
  std::int64_t all = 0;
  for (int i = 0; i < kDoubleWidth; ++i) all |= m[i];
  return all != 0;
}

/// Rays about the point at which they are nearest to the origin of object space: what is far away cancels
/// before a root is looked for. The ray is at o + s d, and s = 0 is the parameter `t` of the given one.
struct DoubleRay {
  Double o[3], d[3];
  Double t;

  /// Lanes [first, first + kDoubleWidth) of `rays`.
  DoubleRay(const ObjectRays& rays, int first);
  /// The same ray in another space, whose `s` is that of `ray` less `t`. Rows of an affine map.
  DoubleRay(const double (&map)[12], const DoubleRay& ray);
  /// The same ray in all lanes.
  explicit DoubleRay(const ExactObjectRay& ray);
  TESSERA_INLINE Double at(int axis, Double s) const { return o[axis] + s * d[axis]; }

 private:
  void begin_nearest_to_origin();
};

/// The most crossings of a ray and a shape: those of a torus, or of a frustum's wall and caps.
inline constexpr int kMostCrossings = 4;
struct Crossings {
  Double s[kMostCrossings];  // ray parameters, in no order; kNoRoot or NaN: none
};

/// Parts of rays within a solid; none where `enter` < `leave` does not hold. Ends may be infinite.
struct SolidSpans {
  Double enter[kMostCrossings / 2], leave[kMostCrossings / 2];  // ray parameters
};

/// A shape that lists all of its crossings.
class CrossedShape : public QuadricShape {
 public:
  /// Those of a convex one: from the first crossing to the last.
  int spans(const ShapeTable& table, const ShapeRecord& shape, const DoubleRay& ray,
            SolidSpans& found) const override;
  void crossings(const ShapeTable& table, const ShapeRecord& shape, std::int32_t, const ExactRay& ray,
                 std::vector<double>& found) const final;

 protected:
  Float nearest_in_object(const ShapeTable& table, const QuadricRecord& q,
                          const ObjectRays& rays) const final;
  /// Fills the first of `found`, and returns their number.
  virtual int cross(const ShapeTable& table, const QuadricRecord& q, const DoubleRay& ray,
                    Crossings& found) const = 0;
};

/// The part of a ray within a convex solid that planes bound, begun as all of it.
struct ConvexSpan {
  Double enter = splat(-kNoRoot), leave = splat(kNoRoot);

  /// Cuts off what is in front of a plane: `above` is the distance of the ray's origin from it, and `slope`
  /// how much that grows along the ray, both in any one unit.
  TESSERA_INLINE void cut(Double above, Double slope) {
    const Double s = -above / slope;
    const DoubleMask in = slope<0.0, out = slope> 0.0, along = ~(in | out);
    enter = in ? upper(enter, s) : enter;
    leave = out ? lower(leave, s) : leave;
    // Along the plane all or nothing is behind it.
    leave = (along & (above > 0.0)) ? splat(-kNoRoot) : leave;
  }
  TESSERA_INLINE int crossings(Crossings& found) const {
    const DoubleMask through = enter <= leave;
    found.s[0] = through ? enter : splat(kNoRoot);
    found.s[1] = through ? leave : splat(kNoRoot);
    return 2;
  }
};

/// Parameters and tangents on a face of a solid in the cube from -1 to 1: those of the side of the cube that
/// is straight along the axis that the normal is closest to, as Box in shape.proto has them. `n` need not be
/// of unit length.
void set_box_parameters(Vec3 n, ObjectPoint& point);

}  // namespace tessera::render::TESSERA_ISA
