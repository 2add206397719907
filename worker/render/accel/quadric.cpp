#include "render/accel/quadric.h"

#include "render/core/affine.h"
#include "render/core/constants.h"
#include "render/shape/shape_table.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Up to 16 rays of a callback's packet, in the quadric's object space.
struct ObjectRays {
  Vec3 o, d;
  Float t_near, t_far;
  Mask active;
};

/// Azimuth and height limits of a partial sphere or a cut disk.
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

/// Calls f(first lane, number of lanes, their roots, which of them hit).
template <class F>
void for_each_chunk(const QuadricGeometry& geometry, const int* valid, RTCRayN* ray, unsigned n, F&& f) {
  const ShapeRecord& shape = geometry.table->shapes[geometry.shape];
  const QuadricRecord& q = geometry.table->quadrics[shape.quadric];
  for (unsigned first = 0; first < n; first += kWidth) {
    const int lanes = static_cast<int>(n - first < kWidth ? n - first : kWidth);
    alignas(64) float f_[8][kWidth] = {};
    alignas(64) std::int32_t v[kWidth] = {};
    for (int i = 0; i < lanes; ++i) {
      const unsigned j = first + i;
      v[i] = valid[j];
      f_[0][i] = RTCRayN_org_x(ray, n, j);
      f_[1][i] = RTCRayN_org_y(ray, n, j);
      f_[2][i] = RTCRayN_org_z(ray, n, j);
      f_[3][i] = RTCRayN_dir_x(ray, n, j);
      f_[4][i] = RTCRayN_dir_y(ray, n, j);
      f_[5][i] = RTCRayN_dir_z(ray, n, j);
      f_[6][i] = RTCRayN_tnear(ray, n, j);
      f_[7][i] = RTCRayN_tfar(ray, n, j);
    }
    const auto load = [&](int k) { return Float::load(f_[k]); };
    const ObjectRays rays{transform_point(q.object_from_render, {load(0), load(1), load(2)}),
                          transform_vector(q.object_from_render, {load(3), load(4), load(5)}), load(6), load(7),
                          Int::load(v) != 0};
    const Float t = shape.kind == ShapeKind::kSphere ? intersect_sphere(q, rays) : intersect_disk(q, rays);
    alignas(64) float roots[kWidth];
    t.store(roots);
    f(first, lanes, roots, (rays.active & (t >= 0.0f)).bits());
  }
}

}  // namespace

void intersect_quadric(const RTCIntersectFunctionNArguments* args) {
  const auto& geometry = *static_cast<const QuadricGeometry*>(args->geometryUserPtr);
  const unsigned n = args->N;
  RTCRayN* ray = RTCRayHitN_RayN(args->rayhit, n);
  RTCHitN* hit = RTCRayHitN_HitN(args->rayhit, n);
  for_each_chunk(geometry, args->valid, ray, n, [&](unsigned first, int, const float* roots, std::uint32_t bits) {
    for (; bits != 0; bits &= bits - 1) {
      const int i = __builtin_ctz(bits);
      const unsigned j = first + static_cast<unsigned>(i);
      RTCRayN_tfar(ray, n, j) = roots[i];
      RTCHitN_geomID(hit, n, j) = args->geomID;
      RTCHitN_primID(hit, n, j) = args->primID;
      RTCHitN_instID(hit, n, j, 0) = args->context->instID[0];
      RTCHitN_u(hit, n, j) = 0;
      RTCHitN_v(hit, n, j) = 0;
    }
  });
}

void occluded_quadric(const RTCOccludedFunctionNArguments* args) {
  const auto& geometry = *static_cast<const QuadricGeometry*>(args->geometryUserPtr);
  for_each_chunk(geometry, args->valid, args->ray, args->N,
                 [&](unsigned first, int, const float*, std::uint32_t bits) {
                   for (; bits != 0; bits &= bits - 1) {
                     RTCRayN_tfar(args->ray, args->N, first + static_cast<unsigned>(__builtin_ctz(bits))) =
                         -__builtin_inff();
                   }
                 });
}

}  // namespace tessera::render::TESSERA_ISA
