#include "render/accel/sdf.h"

#include "render/accel/user_primitive.h"
#include "render/core/affine.h"
#include "render/shape/sdf_voxel.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// A trilinear field along a ray is a cubic [Marmitt et al. 2004].
struct Cubic {
  Float c0, c1, c2, c3;

  TESSERA_INLINE Float operator()(Float t) const { return fma(fma(fma(c3, t, c2), t, c1), t, c0); }
  TESSERA_INLINE Float slope(Float t) const { return fma(fma(3.0f * c3, t, 2.0f * c2), t, c1); }
};

/// Along p + t d in voxel space: the sum over corners of products of three linear factors.
Cubic cubic_along(const SdfVoxel& v, Vec3 p, Vec3 d) {
  // The field as k0 + k1 x + k2 y + k3 xy + z (k4 + k5 x + k6 y + k7 xy).
  const Float* c = v.corner;
  const Float k0 = c[0], k1 = c[1] - c[0], k2 = c[2] - c[0], k3 = (c[3] - c[2]) - k1;
  const Float k4 = c[4] - c[0], k5 = (c[5] - c[4]) - k1, k6 = (c[6] - c[4]) - k2,
              k7 = ((c[7] - c[6]) - (c[5] - c[4])) - k3;
  // x y along the ray, and each bracket as a quadratic in t.
  const Float xy0 = p.x * p.y, xy1 = p.x * d.y + p.y * d.x, xy2 = d.x * d.y;
  const Float a0 = k0 + k1 * p.x + k2 * p.y + k3 * xy0, a1 = k1 * d.x + k2 * d.y + k3 * xy1, a2 = k3 * xy2;
  const Float b0 = k4 + k5 * p.x + k6 * p.y + k7 * xy0, b1 = k5 * d.x + k6 * d.y + k7 * xy1, b2 = k7 * xy2;
  return {a0 + p.z * b0, a1 + p.z * b1 + d.z * b0, a2 + p.z * b2 + d.z * b1, d.z * b2};
}

/// Where [low, high] is split at `root` if it lies within: keeps the first part over which the sign changes.
void split(const Cubic& f, Float root, Mask usable, Float& low, Float& high, Float& f_low, Float& f_high) {
  const Float value = f(root);
  const Mask within = usable & (root > low) & (root < high);
  const Mask first = within & (f_low * value <= 0.0f), second = and_not(within, first);
  high = select(first, root, high);
  f_high = select(first, value, f_high);
  low = select(second, root, low);
  f_low = select(second, value, f_low);
}

/// The first root in [0, end], or a negative number. The derivative's roots cut the range into monotonic
/// parts; Newton's method within a bracket finds the root.
Float first_root(const Cubic& f, Float end, Mask active) {
  const Float a = 3.0f * f.c3, half_b = f.c2, c = f.c1;
  const Float discriminant = half_b * half_b - a * c;
  const Mask turns = discriminant > 0.0f;
  const Float q = -(half_b + copysign(safe_sqrt(discriminant), half_b));
  const Float r0 = q / select(a == 0.0f, 1.0f, a), r1 = c / select(q == 0.0f, 1.0f, q);
  const Mask has_r0 = turns & (a != 0.0f), has_r1 = turns & (q != 0.0f);
  // In order; a root that does not exist stands where it does not matter.
  const Float x = select(has_r0, r0, -1.0f), y = select(has_r1, r1, -1.0f);

  Float low(0.0f), high = end, f_low = f.c0, f_high = f(end);
  split(f, min(x, y), turns, low, high, f_low, f_high);
  split(f, max(x, y), turns, low, high, f_low, f_high);
  const Mask bracketed = active & (f_low * f_high <= 0.0f);
  if (none(bracketed)) return Float(-1.0f);

  const Float slope = f_high - f_low;
  Float t = low - f_low * (high - low) / select(slope == 0.0f, 1.0f, slope);
  t = min(max(t, low), high);
  constexpr int kMostSteps = 40;  // bisection alone needs 24
  for (int i = 0; i < kMostSteps; ++i) {
    const Float value = f(t);
    const Mask before = value * f_low <= 0.0f;
    high = select(before, t, high);
    low = select(before, low, t);
    const Float newton = t - value / f.slope(t);
    const Mask inside = (newton > low) & (newton < high);
    const Float next = select(value == 0.0f, t, select(inside, newton, 0.5f * (low + high)));
    const Mask moves = bracketed & (abs(next - t) > 1e-7f * end);
    t = next;
    if (none(moves)) break;
  }
  return select(bracketed, t, -1.0f);
}

auto solver(const void* user_pointer, unsigned primitive) {
  const auto& geometry = *static_cast<const QuadricGeometry*>(user_pointer);
  const ShapeRecord& shape = geometry.table->shapes[geometry.shape];
  const SdfGridRecord& grid = geometry.table->sdf_grids[shape.quadric];
  return [&grid, primitive](const PrimitiveRays& rays) {
    const Int lower(grid.voxels[primitive]);
    const Vec3 scale = sdf_scale(grid);
    const Vec3 o =
        scaled(transform_point(grid.object_from_render, rays.o), scale) - voxel_position(grid, lower);
    const Vec3 d = scaled(transform_vector(grid.object_from_render, rays.d), scale);

    // The part of the ray within the voxel, and as much around it as the coordinates may be off by: a root on
    // a face that rounding puts outside of both voxels would be a hole. Beyond its voxel the field goes on
    // smoothly.
    const Float slack = (1.0f + max(max(abs(o.x), abs(o.y)), abs(o.z))) * 0x1p-21f;
    Float begin = rays.t_near, end = rays.t_far;
    Mask meets = rays.active;
    const Float from[3] = {o.x, o.y, o.z}, along[3] = {d.x, d.y, d.z};
    for (int a = 0; a < 3; ++a) {
      const Mask moves = abs(along[a]) > 1e-25f;
      const Float inverse = 1.0f / select(moves, along[a], 1.0f);
      const Float t0 = (-slack - from[a]) * inverse, t1 = (1.0f + slack - from[a]) * inverse;
      begin = select(moves, max(begin, min(t0, t1)), begin);
      end = select(moves, min(end, max(t0, t1)), end);
      meets &= moves | ((from[a] >= -slack) & (from[a] <= 1.0f + slack));
    }
    meets &= begin < end;
    if (none(meets)) return Float(-1.0f);
    const SdfVoxel voxel(grid, lower, meets);
    const Float t = first_root(cubic_along(voxel, o + d * begin, d), end - begin, meets);
    const Mask hit = meets & (t >= 0.0f);
    return select(hit & (begin + t > rays.t_near) & (begin + t < rays.t_far), begin + t, -1.0f);
  };
}

}  // namespace

void intersect_sdf(const RTCIntersectFunctionNArguments* args) {
  intersect_primitive(args, solver(args->geometryUserPtr, args->primID));
}
void occluded_sdf(const RTCOccludedFunctionNArguments* args) {
  occluded_primitive(args, solver(args->geometryUserPtr, args->primID));
}

}  // namespace tessera::render::TESSERA_ISA
