#include "render/accel/quadric.h"

#include "render/accel/user_primitive.h"
#include "render/core/affine.h"
#include "render/core/constants.h"
#include "render/shape/shape_table.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Rays in the quadric's object space.
using ObjectRays = PrimitiveRays;

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

/// Nearest root in (t_near, t_far), or a negative number. The discriminant is that of the distance from the centre to
/// the ray, which does not cancel for far or tiny spheres [Hearn & Baker; Haines et al. 2019].
Float intersect_sphere(const QuadricRecord& q, const ObjectRays& r) {
  const Float a = length_squared(r.d);
  const Float inv_a = 1.0f / a;
  const Float b = -dot(r.o, r.d);  // a times the parameter of the nearest approach
  const Vec3 nearest = r.o + r.d * (b * inv_a);
  const Float discriminant = Float(sqr(Float(q.radius))) - length_squared(nearest);
  const Mask meets = r.active & (discriminant >= 0.0f);
  if (none(meets)) return Float(-1.0f);

  const Float c = (length(r.o) - q.radius) * (length(r.o) + q.radius);
  const Float far = b + copysign(sqrt(max(discriminant, 0.0f) * a), b);
  const Float t_a = c / select(far == 0.0f, 1.0f, far), t_b = far * inv_a;
  const Float t0 = min(t_a, t_b), t1 = max(t_a, t_b);
  const auto usable = [&](Float t) {
    return meets & (t > r.t_near) & (t < r.t_far) & inside_limits(q, ShapeKind::kSphere, r.o + r.d * t);
  };
  const Mask first = usable(t0);
  const Mask second = and_not(usable(t1), first);
  return select(first, t0, select(second, t1, -1.0f));
}

Float intersect_disk(const QuadricRecord& q, const ObjectRays& r) {
  const Mask slanted = r.active & (r.d.z != 0.0f);
  const Float t = (q.height - r.o.z) / select(slanted, r.d.z, 1.0f);
  const Vec3 p = r.o + r.d * t;
  const Float r2 = sqr(p.x) + sqr(p.y);
  const Mask hit = slanted & (t > r.t_near) & (t < r.t_far) & (r2 <= q.radius * q.radius) &
                   (r2 >= q.inner_radius * q.inner_radius) & inside_limits(q, ShapeKind::kDisk, p);
  return select(hit, t, -1.0f);
}

Float intersect_cylinder(const QuadricRecord& q, const ObjectRays& r) {
  // The same in the plane across the axis.
  const Float a = sqr(r.d.x) + sqr(r.d.y);
  const Mask slanted = r.active & (a > 0.0f);
  const Float inv_a = 1.0f / select(slanted, a, 1.0f);
  const Float b = -(r.o.x * r.d.x + r.o.y * r.d.y);
  const Float nx = r.o.x + r.d.x * (b * inv_a), ny = r.o.y + r.d.y * (b * inv_a);
  const Float discriminant = Float(sqr(Float(q.radius))) - (sqr(nx) + sqr(ny));
  const Mask meets = slanted & (discriminant >= 0.0f);
  if (none(meets)) return Float(-1.0f);

  const Float distance = sqrt(sqr(r.o.x) + sqr(r.o.y));
  const Float c = (distance - q.radius) * (distance + q.radius);
  const Float far = b + copysign(sqrt(max(discriminant, 0.0f) * a), b);
  const Float t_a = c / select(far == 0.0f, 1.0f, far), t_b = far * inv_a;
  const Float t0 = min(t_a, t_b), t1 = max(t_a, t_b);
  const auto usable = [&](Float t) {
    const Vec3 p = r.o + r.d * t;
    return meets & (t > r.t_near) & (t < r.t_far) & (p.z >= q.z_min) & (p.z <= q.z_max) &
           inside_limits(q, ShapeKind::kCylinder, p);
  };
  const Mask first = usable(t0);
  const Mask second = and_not(usable(t1), first);
  return select(first, t0, select(second, t1, -1.0f));
}

Float intersect_shape(const QuadricRecord& q, ShapeKind kind, const ObjectRays& r) {
  switch (kind) {
    case ShapeKind::kSphere: return intersect_sphere(q, r);
    case ShapeKind::kCylinder: return intersect_cylinder(q, r);
    default: return intersect_disk(q, r);
  }
}

/// Roots of rays in render space.
auto solver(const void* user_pointer) {
  const auto& geometry = *static_cast<const QuadricGeometry*>(user_pointer);
  const ShapeRecord& shape = geometry.table->shapes[geometry.shape];
  const QuadricRecord& q = geometry.table->quadrics[shape.quadric];
  return [&q, kind = shape.kind](const PrimitiveRays& rays) {
    return intersect_shape(q, kind,
                           {transform_point(q.object_from_render, rays.o), transform_vector(q.object_from_render, rays.d),
                            rays.t_near, rays.t_far, rays.active});
  };
}

}  // namespace

void intersect_quadric(const RTCIntersectFunctionNArguments* args) { intersect_primitive(args, solver(args->geometryUserPtr)); }
void occluded_quadric(const RTCOccludedFunctionNArguments* args) { occluded_primitive(args, solver(args->geometryUserPtr)); }

}  // namespace tessera::render::TESSERA_ISA
