#include "optics/paraxial.h"

#include <cmath>

namespace tessera::optics {

namespace {

struct Matrix {
  double a = 1, b = 0, c = 0, d = 1;
};
Matrix operator*(const Matrix& m, const Matrix& n) {
  return {m.a * n.a + m.b * n.c, m.a * n.b + m.b * n.d, m.c * n.a + m.d * n.c, m.c * n.b + m.d * n.d};
}

/// Curvature of the vertex: of cylinders that are straight along y, none.
double curvature_of(const Surface& surface) {
  if (surface.radius == 0) return 0;
  if (!surface.cylindrical) return 1 / surface.radius;
  const double across = std::cos(surface.axis_degrees * 0.017453292519943295);
  return across * across / surface.radius;
}

Matrix refraction(const Surface& surface, double before, double behind) {
  return {1, 0, -(behind - before) * curvature_of(surface) / behind, before / behind};
}

}  // namespace

Paraxial paraxial_of(const Prescription& lens, double nm) {
  Matrix all, to_stop, from_stop;
  double before = 1, length = 0;
  bool behind_stop = false;
  for (std::size_t i = 0; i < lens.surfaces.size(); ++i) {
    const Surface& surface = lens.surfaces[i];
    const double behind = surface.behind.eta(nm);
    const Matrix here = refraction(surface, before, behind);
    if (surface.stop) to_stop = all, behind_stop = true;
    all = here * all;
    if (behind_stop) from_stop = here * from_stop;
    before = behind;
    if (i + 1 == lens.surfaces.size()) break;
    const Matrix way{1, surface.thickness, 0, 1};
    all = way * all;
    if (behind_stop) from_stop = way * from_stop;
    length += surface.thickness;
  }
  Paraxial result{all.a, all.b, all.c, all.d, length};
  // Rays through the middle of the stop have height 0 there: where they would cross the axis in air, before
  // the lens and behind it, are the pupils.
  result.exit_pupil = -from_stop.b / from_stop.d;
  result.exit_magnification = from_stop.a + result.exit_pupil * from_stop.c;
  result.entrance_pupil = to_stop.b / to_stop.a;
  result.entrance_magnification = 1 / to_stop.a;
  return result;
}

double seidel_spherical(const Prescription& lens, double height, double object, double nm) {
  double h = height, u = std::isinf(object) ? 0 : height / object, before = 1, sum = 0;
  for (const Surface& surface : lens.surfaces) {
    const double behind = surface.behind.eta(nm), c = curvature_of(surface);
    const double a = before * (h * c + u);
    const double u_behind = (before * u - h * c * (behind - before)) / behind;
    sum -= a * a * h * (u_behind / behind - u / before);
    // An aspheric surface's own term: the change of its height from that of the sphere.
    const double fourth =
        (surface.aspheric.empty() ? 0 : 8 * surface.aspheric[0]) + surface.conic * c * c * c;
    sum += fourth * (behind - before) * h * h * h * h;
    h += surface.thickness * u_behind;
    u = u_behind, before = behind;
  }
  return sum;
}

}  // namespace tessera::optics
