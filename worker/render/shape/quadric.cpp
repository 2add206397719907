#include "render/shape/quadric.h"

#include <cmath>

#include "render/shape/error_bound.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// Parameters other than pbrt's, and the tangents that belong to them.
void map_parameters(const QuadricRecord& q, ObjectPoint& point) {
  const float* m = q.uv_map;
  const Vec2 uv = point.uv;
  point.uv = {m[0] * uv.x + m[1] * uv.y + m[2], m[3] * uv.x + m[4] * uv.y + m[5]};
  const float determinant = m[0] * m[4] - m[1] * m[3];
  const float inverse = determinant == 0 ? 0 : 1 / determinant;
  const Vec3 dpdu = point.dpdu, dpdv = point.dpdv;
  point.dpdu = (dpdu * Float(m[4]) - dpdv * Float(m[3])) * Float(inverse);
  point.dpdv = (dpdv * Float(m[0]) - dpdu * Float(m[1])) * Float(inverse);
}

}  // namespace

void QuadricShape::surface(const ShapeTable& table, const ShapeRecord& shape, const Hit& hit, Vec3 o, Vec3 d,
                           Mask active, bool want_tangents, Surface& s) const {
  const QuadricRecord& q = table.quadrics[shape.quadric];
  const Vec3 oo = transform_point(q.object_from_render, o), od = transform_vector(q.object_from_render, d);
  const Vec3 guess = fma(od, hit.t, oo);
  ObjectPoint point = point_in_object(table, q, guess);
  if (q.maps_uv) map_parameters(q, point);
  const Vec3 p = transform_point(q.render_from_object, point.p);
  Vec3 ng = normalize(transform_normal(q.object_from_render, point.n));
  if (shape.flags & kFlipNormal) ng = -ng;

  // The transform's own roundings count: the extent of the object about its origin, seen in render space.
  const Vec3 spread = transform_vector(q.render_from_object, Vec3{point.extent, point.extent, point.extent});
  const Float extent = largest_coordinate(p) + largest_coordinate(spread) +
                       std::abs(q.render_from_object.m[3]) + std::abs(q.render_from_object.m[7]) +
                       std::abs(q.render_from_object.m[11]);
  s.p = select(active, p, s.p);
  s.error = select(active, along_normal(ng, extent * kPositionError), s.error);
  s.ng = select(active, ng, s.ng);
  s.ns = select(active, ng, s.ns);
  s.uv = {select(active, point.uv.x, s.uv.x), select(active, point.uv.y, s.uv.y)};
  if (want_tangents) {
    s.dpdu = select(active, transform_vector(q.render_from_object, point.dpdu), s.dpdu);
    s.dpdv = select(active, transform_vector(q.render_from_object, point.dpdv), s.dpdv);
  }
}

}  // namespace tessera::render::TESSERA_ISA
