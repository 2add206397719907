#include "render/accel/quadric.h"

#include "render/accel/user_primitive.h"
#include "render/core/affine.h"
#include "render/core/constants.h"
#include "render/shape/shape_table.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// What rounding leaves of a sum: `value` + `rest` is right to twice the digits of a float.
struct Exact {
  Float value, rest;
};
TESSERA_INLINE Exact two_product(Float a, Float b) {
  const Float p = a * b;
  return {p, fma(a, b, -p)};
}
TESSERA_INLINE Exact two_sum(Float a, Float b) {
  const Float s = a + b, of_b = s - a;
  return {s, (a - (s - of_b)) + (b - of_b)};
}
/// a . b + c [Ogita, Rump & Oishi 2005].
TESSERA_INLINE Exact exact_dot(const float (&a)[12], int row, Vec3 b, float c) {
  const Exact x = two_product(Float(a[row]), b.x), y = two_product(Float(a[row + 1]), b.y),
              z = two_product(Float(a[row + 2]), b.z);
  const Exact xy = two_sum(x.value, y.value), zc = two_sum(z.value, Float(c)),
              all = two_sum(xy.value, zc.value);
  return two_sum(all.value, ((x.rest + y.rest) + z.rest) + ((xy.rest + zc.rest) + all.rest));
}

/// Rays in the quadric's object space, with what rounding took off them: seen from a million radii away, a
/// float's last place is a tenth of the radius.
struct ObjectRays {
  Vec3 o, d;
  Vec3 o_rest, d_rest;
  Float t_near, t_far;
  Mask active;

  ObjectRays(const Affine& object_from_render, const PrimitiveRays& r)
      : t_near(r.t_near), t_far(r.t_far), active(r.active) {
    const auto& m = object_from_render.m;
    const auto place = [&](Vec3 v, float with_shift, Vec3& value, Vec3& rest) {
      const Exact x = exact_dot(m, 0, v, with_shift * m[3]), y = exact_dot(m, 4, v, with_shift * m[7]),
                  z = exact_dot(m, 8, v, with_shift * m[11]);
      value = {x.value, y.value, z.value};
      rest = {x.rest, y.rest, z.rest};
    };
    place(r.o, 1, o, o_rest);
    place(r.d, 0, d, d_rest);
  }
  /// The point at `t`, each coordinate rounded at its own size however far away it is.
  TESSERA_INLINE Vec3 at(Float t) const {
    const auto along = [t](Float from, Float way, Float from_rest, Float way_rest) {
      return fma(way, t, from) + fma(way_rest, t, from_rest);
    };
    return {along(o.x, d.x, o_rest.x, d_rest.x), along(o.y, d.y, o_rest.y, d_rest.y),
            along(o.z, d.z, o_rest.z, d_rest.z)};
  }
};

/// Nearest root in (t_near, t_far) whose point is inside the limits, or a negative number. The roots are t +
/// rest -+ half_chord, and `middle` is the point at t + rest.
template <class Inside>
Float nearest_root(const ObjectRays& r, Mask meets, Float t, Float rest, Float half_chord, Vec3 middle,
                   Inside&& inside) {
  const Float t0 = t + (rest - half_chord), t1 = t + (rest + half_chord);
  const auto usable = [&](Float root, Vec3 p) {
    return meets & (root > r.t_near) & (root < r.t_far) & inside(p);
  };
  const Mask first = usable(t0, middle - r.d * half_chord);
  const Mask second = and_not(usable(t1, middle + r.d * half_chord), first);
  return select(first, t0, select(second, t1, -1.0f));
}

/// Azimuth limit of a cut disk or cylinder; azimuth and height limits of a partial sphere.
Mask inside_limits(const QuadricRecord& q, ShapeKind kind, Vec3 p) {
  if (!q.partial) return Mask::all();
  Float phi = atan2(p.y, p.x);
  phi = select(phi < 0.0f, phi + 2 * kPi, phi);
  Mask inside = phi <= q.phi_max;
  if (kind == ShapeKind::kSphere) {
    if (q.z_min > -q.radius) inside &= p.z >= q.z_min;
    if (q.z_max < q.radius) inside &= p.z <= q.z_max;
  }
  return inside;
}

/// The discriminant is that of the distance from the centre to the ray [Hearn & Baker; Haines et al. 2019].
/// The nearest point is found twice, the second time from the first, so that it does not cancel for far or
/// tiny spheres.
Float intersect_sphere(const QuadricRecord& q, const ObjectRays& r) {
  const Float inv_a = 1.0f / length_squared(r.d);
  const Float t = -dot(r.o, r.d) * inv_a;
  const Vec3 near_it = r.at(t);
  const Float rest = -dot(near_it, r.d) * inv_a;
  const Vec3 nearest = near_it + r.d * rest;
  const Float discriminant = Float(sqr(Float(q.radius))) - length_squared(nearest);
  const Mask meets = r.active & (discriminant >= 0.0f);
  if (none(meets)) return Float(-1.0f);
  return nearest_root(r, meets, t, rest, safe_sqrt(discriminant * inv_a), nearest,
                      [&](Vec3 p) { return inside_limits(q, ShapeKind::kSphere, p); });
}

Float intersect_disk(const QuadricRecord& q, const ObjectRays& r) {
  const Mask slanted = r.active & (r.d.z != 0.0f);
  const Float inv_z = 1.0f / select(slanted, r.d.z, 1.0f);
  const Float t = (q.height - r.o.z) * inv_z;
  const Vec3 near_it = r.at(t);
  const Float rest = (q.height - near_it.z) * inv_z;
  const Vec3 p = near_it + r.d * rest;
  const Float root = t + rest, r2 = sqr(p.x) + sqr(p.y);
  const Mask hit = slanted & (root > r.t_near) & (root < r.t_far) & (r2 <= q.radius * q.radius) &
                   (r2 >= q.inner_radius * q.inner_radius) & inside_limits(q, ShapeKind::kDisk, p);
  return select(hit, root, -1.0f);
}

/// As a sphere, in the plane across the axis.
Float intersect_cylinder(const QuadricRecord& q, const ObjectRays& r) {
  const Float a = sqr(r.d.x) + sqr(r.d.y);
  const Mask slanted = r.active & (a > 0.0f);
  const Float inv_a = 1.0f / select(slanted, a, 1.0f);
  const Float t = -(r.o.x * r.d.x + r.o.y * r.d.y) * inv_a;
  const Vec3 near_it = r.at(t);
  const Float rest = -(near_it.x * r.d.x + near_it.y * r.d.y) * inv_a;
  const Vec3 nearest = near_it + r.d * rest;
  const Float discriminant = Float(sqr(Float(q.radius))) - (sqr(nearest.x) + sqr(nearest.y));
  const Mask meets = slanted & (discriminant >= 0.0f);
  if (none(meets)) return Float(-1.0f);
  return nearest_root(r, meets, t, rest, safe_sqrt(discriminant * inv_a), nearest, [&](Vec3 p) {
    return (p.z >= q.z_min) & (p.z <= q.z_max) & inside_limits(q, ShapeKind::kCylinder, p);
  });
}

Float intersect_shape(const QuadricRecord& q, ShapeKind kind, const ObjectRays& r) {
  switch (kind) {
    case ShapeKind::kSphere:
      return intersect_sphere(q, r);
    case ShapeKind::kCylinder:
      return intersect_cylinder(q, r);
    default:
      return intersect_disk(q, r);
  }
}

/// Roots of rays in render space.
auto solver(const void* user_pointer) {
  const auto& geometry = *static_cast<const QuadricGeometry*>(user_pointer);
  const ShapeRecord& shape = geometry.table->shapes[geometry.shape];
  const QuadricRecord& q = geometry.table->quadrics[shape.quadric];
  return [&q, kind = shape.kind](const PrimitiveRays& rays) {
    return intersect_shape(q, kind, ObjectRays(q.object_from_render, rays));
  };
}

}  // namespace

void intersect_quadric(const RTCIntersectFunctionNArguments* args) {
  intersect_primitive(args, solver(args->geometryUserPtr));
}
void occluded_quadric(const RTCOccludedFunctionNArguments* args) {
  occluded_primitive(args, solver(args->geometryUserPtr));
}

}  // namespace tessera::render::TESSERA_ISA
