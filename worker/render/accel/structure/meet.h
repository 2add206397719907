// Tests of single primitives, the same for all structures.
#pragma once

#include <algorithm>
#include <cmath>

#include "render/accel/structure/ray.h"

namespace tessera::render {
struct ShapeTable;
struct TextureTable;
}  // namespace tessera::render

namespace tessera::render::TESSERA_ISA {

/// Parameter along the ray, and weights of a triangle's second and third corner.
struct Meeting {
  float t, u, v;
};

/// Whether a triangle, sheared, is so thin beside its length that what rounding took off the edge functions
/// would move a hit by more than boxes are padded. `sum` is twice its area. Coordinates are off by 2^-52 of
/// the largest one, M; times the triangle's width that is what the functions are off by; over `sum` and times
/// its length, the hit. That is below 2^-20 M where `sum` is above 2^-30 of width times length.
TESSERA_INLINE bool is_seen_edge_on(const double (&px)[3], const double (&py)[3], const double (&pz)[3],
                                    double sum) {
  const auto extent = [](const double(&p)[3]) {
    return std::max({p[0], p[1], p[2]}) - std::min({p[0], p[1], p[2]});
  };
  const double width = std::max(extent(px), extent(py)), length = std::max(width, extent(pz));
  return std::abs(sum) <= 0x1p-30 * width * length;
}

/// Watertight [Woop, Benthin & Wald 2013]: the corners are sheared so that the ray runs along z, alike in all
/// triangles that share them, and three edge functions say where it passes. They are computed in double: a
/// product that is rounded keeps its order, so a ray between two triangles meets one of them at least. What
/// is seen edge-on is not met: its neighbours are.
TESSERA_INLINE bool meet_triangle(const Ray& ray, const float (&corners)[3][3], Meeting& meeting) {
  double px[3], py[3], pz[3];
  for (int c = 0; c < 3; ++c) {
    pz[c] = corners[c][ray.z] - ray.o[ray.z];
    px[c] = corners[c][ray.x] - ray.o[ray.x] - ray.shear_x * pz[c];
    py[c] = corners[c][ray.y] - ray.o[ray.y] - ray.shear_y * pz[c];
  }
  const double w0 = px[2] * py[1] - py[2] * px[1];
  const double w1 = px[0] * py[2] - py[0] * px[2];
  const double w2 = px[1] * py[0] - py[1] * px[0];
  if ((w0 < 0 || w1 < 0 || w2 < 0) && (w0 > 0 || w1 > 0 || w2 > 0)) return false;
  const double sum = w0 + w1 + w2;
  if (is_seen_edge_on(px, py, pz, sum)) return false;
  const double inverse = 1 / sum;
  const double t = (w0 * pz[0] + w1 * pz[1] + w2 * pz[2]) * inverse * ray.inverse_z;
  if (!(t > 0)) return false;
  meeting = {static_cast<float>(t), static_cast<float>(w1 * inverse), static_cast<float>(w2 * inverse)};
  return true;
}

/// The nearest hit of an analytic shape up to `most`, this included, that is no hole. A hit outside of the
/// shape's box is none, for a structure need not find it.
bool meet_analytic(const Ray& ray, const ShapeTable& table, const TextureTable& textures,
                   const Primitive& primitive, float most, Meeting& meeting);

/// The hit of a triangle of a mesh that deforms, as it is at the ray's time.
bool meet_deforming(const Ray& ray, const ShapeTable& table, const Primitive& primitive, Meeting& meeting);

/// Whether a ray passes through a point of a mesh with alpha.
bool passes_through(const Ray& ray, const ShapeTable& table, const TextureTable& textures,
                    const Primitive& primitive, const Meeting& meeting);

}  // namespace tessera::render::TESSERA_ISA
