// Points on surfaces that emit light.
#pragma once

#include "render/core/constants.h"
#include "render/light/quadric_access.h"
#include "render/sampling/warp.h"
#include "render/shape/triangle_normal.h"

namespace tessera::render::TESSERA_ISA {

/// A point of an emitting surface, in render space.
struct AreaPoint {
  Vec3 point, normal;  // unit, on the side that counts as the front
  Float density;       // of the point by area
  Float extent;        // largest coordinate of the shape about its own origin
};

/// Density by area of a point that is chosen uniformly by area in object space, `object_area` being all of
/// it. `n` is the unit normal there, in object space; areas scale by |det M| |M^-T n|.
TESSERA_INLINE Float stretched_density(Float object_area, const WideAffine& to, const WideAffine& from,
                                       Vec3 n) {
  const auto& m = to.m;
  const Float determinant = dot(Vec3{m[0], m[1], m[2]}, cross({m[4], m[5], m[6]}, {m[8], m[9], m[10]}));
  return 1.0f / (object_area * abs(determinant) * length(transform_normal(from, n)));
}

/// Area of the zone of a sphere, or of the wall of a cylinder [Archimedes: they are the same].
TESSERA_INLINE Float zone_area(const QuadricLanes& quadric) {
  return quadric.field(&QuadricRecord::radius) * quadric.field(&QuadricRecord::phi_max) *
         (quadric.field(&QuadricRecord::z_max) - quadric.field(&QuadricRecord::z_min));
}

TESSERA_INLINE AreaPoint sample_sphere_area(const LightLanes& lanes, Vec2 u) {
  const QuadricLanes quadric(lanes);
  const Float radius = quadric.field(&QuadricRecord::radius);
  const Float z = lerp(u.x, quadric.field(&QuadricRecord::z_min), quadric.field(&QuadricRecord::z_max));
  const Float r = safe_sqrt((radius - z) * (radius + z));
  const Float phi = u.y * quadric.field(&QuadricRecord::phi_max);
  const Vec3 in_object = {r * cos(phi), r * sin(phi), z};

  const WideAffine to = quadric.affine(&QuadricRecord::render_from_object);
  const WideAffine from = quadric.affine(&QuadricRecord::object_from_render);
  const Vec3 n = in_object * (1.0f / radius);
  return {transform_point(to, in_object), quadric.front(normalize(transform_normal(from, n))),
          stretched_density(zone_area(quadric), to, from, n),
          max_abs(transform_vector(to, {radius, radius, radius}))};
}
TESSERA_INLINE Float sphere_area_density(const LightLanes& lanes, Vec3 point) {
  const QuadricLanes quadric(lanes);
  const WideAffine from = quadric.affine(&QuadricRecord::object_from_render);
  return stretched_density(zone_area(quadric), quadric.affine(&QuadricRecord::render_from_object), from,
                           normalize(transform_point(from, point)));
}

TESSERA_INLINE AreaPoint sample_cylinder_area(const LightLanes& lanes, Vec2 u) {
  const QuadricLanes quadric(lanes);
  const Float radius = quadric.field(&QuadricRecord::radius);
  const Float z_min = quadric.field(&QuadricRecord::z_min), z_max = quadric.field(&QuadricRecord::z_max);
  const Float phi = u.x * quadric.field(&QuadricRecord::phi_max);
  const Vec3 n{cos(phi), sin(phi), Float(0.0f)};
  const WideAffine to = quadric.affine(&QuadricRecord::render_from_object);
  const WideAffine from = quadric.affine(&QuadricRecord::object_from_render);
  return {transform_point(to, {n.x * radius, n.y * radius, lerp(u.y, z_min, z_max)}),
          quadric.front(normalize(transform_normal(from, n))),
          stretched_density(zone_area(quadric), to, from, n),
          max_abs(transform_vector(to, {radius, radius, max(abs(z_min), abs(z_max))}))};
}
TESSERA_INLINE Float cylinder_area_density(const LightLanes& lanes, Vec3 point) {
  const QuadricLanes quadric(lanes);
  const WideAffine from = quadric.affine(&QuadricRecord::object_from_render);
  const Vec3 p = transform_point(from, point);
  return stretched_density(zone_area(quadric), quadric.affine(&QuadricRecord::render_from_object), from,
                           normalize(Vec3{p.x, p.y, Float(0.0f)}));
}

/// An affine map keeps a uniform density of a plane figure uniform, so any transform will do.
TESSERA_INLINE AreaPoint sample_disk_area(const LightLanes& lanes, Vec2 u) {
  const QuadricLanes quadric(lanes);
  const Float radius = quadric.field(&QuadricRecord::radius),
              inner = quadric.field(&QuadricRecord::inner_radius);
  // The unit disk, drawn out to the ring between the radii and squeezed into the sector; both keep ratios of
  // areas.
  const Polar unit = square_to_disk_polar(u);
  const Float r = sqrt(lerp(sqr(unit.radius), sqr(inner), sqr(radius)));
  const Float turn = select(unit.angle < 0.0f, unit.angle + 2.0f * kPi, unit.angle);
  const Float phi = turn * (quadric.field(&QuadricRecord::phi_max) * kInv2Pi);
  const WideAffine to = quadric.affine(&QuadricRecord::render_from_object);
  const WideAffine from = quadric.affine(&QuadricRecord::object_from_render);
  return {transform_point(to, {r * cos(phi), r * sin(phi), quadric.field(&QuadricRecord::height)}),
          quadric.front(normalize(transform_normal(from, {0.0f, 0.0f, 1.0f}))),
          1.0f / lanes.field(&LightRecord::area), max_abs(transform_vector(to, {radius, radius, 0.0f}))};
}

/// A kRectangle's corner, the unit vectors along its sides and across, and the sides' lengths.
struct RectangleSides {
  Vec3 corner, x, y, normal;
  Float width, height;

  TESSERA_INLINE explicit RectangleSides(const LightLanes& lanes)
      : corner(lanes.field3(&LightRecord::vertices, 0)),
        x(lanes.field3(&LightRecord::vertices, 3)),
        y(lanes.field3(&LightRecord::vertices, 6)),
        normal(lanes.field3(&LightRecord::direction)),
        width(lanes.field(&LightRecord::tan_x)),
        height(lanes.field(&LightRecord::tan_y)) {}
};

/// The point of a rectangle at these parts of its sides.
TESSERA_INLINE AreaPoint rectangle_point(const LightLanes& lanes, const RectangleSides& r, Vec2 parts) {
  return {fma(r.y, parts.y * r.height, fma(r.x, parts.x * r.width, r.corner)), r.normal,
          1.0f / lanes.field(&LightRecord::area), max(r.width, r.height)};
}

/// A triangle light's corners at `u`.
struct TrianglePoint {
  AreaPoint at;
  Vec2 barycentric;
};
TESSERA_INLINE TrianglePoint sample_triangle_area(const LightLanes& lanes, Vec2 u) {
  const Vec3 p0 = lanes.field3(&LightRecord::vertices, 0);
  const Vec3 p1 = lanes.field3(&LightRecord::vertices, 3);
  const Vec3 p2 = lanes.field3(&LightRecord::vertices, 6);
  const Vec3 e1 = p1 - p0, e2 = p2 - p0;
  const Float size = max(max_abs(e1), max_abs(e2));
  const Barycentric b = square_to_triangle(u);
  return {{fma(p2, b.b2, fma(p1, b.b1, p0 * b.b0)), triangle_normal(e1, e2, size),
           1.0f / lanes.field(&LightRecord::area), size},
          {b.b1, b.b2}};
}

}  // namespace tessera::render::TESSERA_ISA
