// All crossings of a line and a mesh, each of them once.
#pragma once

#include <cmath>

#include "render/accel/structure/ray.h"

namespace tessera::render::TESSERA_ISA {

/// a b - c d: its sign is exact, unless products underflow. A product and what rounding took off it are two
/// doubles [Ogita2005].
inline double difference_of_products(double a, double b, double c, double d) {
  const double p = a * b, q = c * d;
  const double p_rest = std::fma(a, b, -p), q_rest = std::fma(c, d, -q);
  const double rest = p_rest - q_rest, of_q = p_rest - rest;
  const double lost = (p_rest - (rest + of_q)) + (of_q - q_rest);
  const double sum = (p - q) + rest;
  return sum != 0 ? sum : lost;
}

/// An edge, sheared so that the ray runs along z through the origin, and the side of it on which the ray is.
struct EdgeSide {
  double size;  // size of the edge function
  bool above, below;

  /// Where the ray meets the edge, it is taken to be beside it, by (e, e^2) with e infinitely small
  /// [Edelsbrunner1990]: neither side, where both ends are one point.
  EdgeSide(double ax, double ay, double bx, double by) : size(difference_of_products(bx, ay, by, ax)) {
    const double side = size != 0 ? size : by != ay ? by - ay : ax - bx;
    above = side > 0, below = side < 0;
  }
};

struct TriangleCrossing {
  double t, b1, b2;
  bool against;  // the triangle's normal
};

/// Where the line crosses, at t > 0. The corners are sheared as in accel/structure/meet.h, alike in all
/// triangles that share them; from there on all decisions are exact.
inline bool cross_triangle(const Ray& ray, const float (&corners)[3][3], TriangleCrossing& crossing) {
  double px[3], py[3], pz[3];
  for (int c = 0; c < 3; ++c) {
    pz[c] = corners[c][ray.z] - ray.o[ray.z];
    px[c] = corners[c][ray.x] - ray.o[ray.x] - ray.shear_x * pz[c];
    py[c] = corners[c][ray.y] - ray.o[ray.y] - ray.shear_y * pz[c];
  }
  const EdgeSide e0(px[1], py[1], px[2], py[2]), e1(px[2], py[2], px[0], py[0]),
      e2(px[0], py[0], px[1], py[1]);
  if (!(e0.above && e1.above && e2.above) && !(e0.below && e1.below && e2.below)) return false;
  const double inverse = 1 / (e0.size + e1.size + e2.size);
  crossing.b1 = e1.size * inverse, crossing.b2 = e2.size * inverse;
  crossing.t = (e0.size * pz[0] + e1.size * pz[1] + e2.size * pz[2]) * inverse * ray.inverse_z;
  crossing.against = e0.above == (ray.d[ray.z] > 0);
  return crossing.t > 0;
}

}  // namespace tessera::render::TESSERA_ISA
