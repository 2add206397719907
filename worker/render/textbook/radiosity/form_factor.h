// Form factors in closed form: the share of a small surface's light that comes from a polygon, if nothing is
// in the way.
#pragma once

#include "render/textbook/radiosity/patches.h"

namespace tessera::render::TESSERA_ISA::radiosity {

/// A triangle, or what is left of it above a horizon.
struct Polygon {
  Vec corner[4];
  int size = 0;

  /// Evenly over the polygon, of numbers in [0, 1).
  Vec point(double u, double v) const;
};

/// The part of a triangle that is above the tangent plane at `x`.
Polygon above_horizon(const Vec& x, const Vec& normal, const Vec (&triangle)[3]);

/// Form factor from a point with unit normal `normal` to a polygon above its horizon, on whichever side the
/// polygon is seen [Lambert 1760]: exact, but for roundings.
double form_factor(const Vec& x, const Vec& normal, const Polygon& polygon);

/// Points at which a patch is asked for its form factors, in weights of its corners: their mean is exact for
/// what is quadratic over the patch.
inline constexpr int kPoints = 3;
inline constexpr Weights kPoint[kPoints] = {
    {{2 / 3.0, 1 / 6.0, 1 / 6.0}}, {{1 / 6.0, 2 / 3.0, 1 / 6.0}}, {{1 / 6.0, 1 / 6.0, 2 / 3.0}}};

/// View of a source from each of a receiver's points, if nothing is in the way.
struct View {
  Polygon seen[kPoints];
  double factor[kPoints] = {0, 0, 0};

  double largest() const;
  double spread() const;  // difference of the largest and the smallest
  double mean() const { return (factor[0] + factor[1] + factor[2]) / kPoints; }
};
View view(const Patch& receiver, const Patch& source);

}  // namespace tessera::render::TESSERA_ISA::radiosity
