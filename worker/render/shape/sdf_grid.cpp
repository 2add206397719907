#include <cmath>

#include "render/core/affine.h"
#include "render/shape/analytic_shape.h"
#include "render/shape/error_bound.h"
#include "render/shape/implicit/refine_bracket.h"
#include "render/shape/sdf_voxel.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// A trilinear field along a ray is a cubic [Marmitt et al. 2004].
struct Cubic {
  Float c0, c1, c2, c3;

  TESSERA_INLINE Float operator()(Float t) const { return fma(fma(fma(c3, t, c2), t, c1), t, c0); }
  TESSERA_INLINE Dual<Float, 1> with_slope(Float t) const {
    return {(*this)(t), {fma(fma(3.0f * c3, t, 2.0f * c2), t, c1)}};
  }
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
/// parts; Newton's method within a bracket finds the root, from where a line through its ends is zero.
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
  const Float start = low - f_low * (high - low) / select(slope == 0.0f, 1.0f, slope);
  const Float root = refine_bracket(f, low, high, min(max(start, low), high), bracketed, 1e-7f * end);
  return select(bracketed, root, -1.0f);
}

/// A sample of the grid, the nearest one for places outside.
Float sample_at(const SdfGridRecord& grid, Int x, Int y, Int z, Mask active) {
  const auto inside = [](Int i, std::int32_t size) { return min(max(i, 0), size - 1); };
  const Int index = (inside(z, grid.size[2]) * grid.size[1] + inside(y, grid.size[1])) * grid.size[0] +
                    inside(x, grid.size[0]);
  return gather(grid.samples.data(), index, active);
}

/// The gradient that is continuous across voxels: a blend of those of the eight voxels about the nearest
/// sample, each continued to `p` [Hansson-Soederlund, Evans & Akenine-Moeller 2022]. `p` in grid coordinates.
Vec3 smooth_gradient(const SdfGridRecord& grid, Vec3 p, Mask active) {
  const Float along[3] = {p.x, p.y, p.z};
  Int cell[3], low[3];  // of the voxel around p, and of the lower of the eight
  Float within[3], blend[3];
  for (int a = 0; a < 3; ++a) {
    cell[a] = min(max(to_int(floor(along[a])), 0), grid.size[a] - 2);
    low[a] = to_int(floor(along[a] + 0.5f)) - 1;
    within[a] = along[a] - to_float(cell[a]);
    blend[a] = along[a] - to_float(low[a]) - 0.5f;
  }
  // The interpolated field on the plane of samples `q` across axis `a`.
  const auto plane = [&](int a, Int q) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    Float f[4];
    for (int i = 0; i < 4; ++i) {
      Int at[3];
      at[a] = q;
      at[b] = cell[b] + (i & 1);
      at[c] = cell[c] + (i >> 1);
      f[i] = sample_at(grid, at[0], at[1], at[2], active);
    }
    return lerp(within[c], lerp(within[b], f[0], f[1]), lerp(within[b], f[2], f[3]));
  };
  const Vec3 scale = sdf_scale(grid);
  const Float scales[3] = {scale.x, scale.y, scale.z};
  Float difference[3][2];  // of the lower and the upper voxel along an axis
  for (int a = 0; a < 3; ++a) {
    const Mask upper = cell[a] != low[a];
    const Float g0 = plane(a, cell[a]), g1 = plane(a, cell[a] + 1);
    const Float beyond = plane(a, cell[a] + select(upper, Int(-1), Int(2)));
    const Float here = (g1 - g0) * scales[a];
    const Float there = select(upper, g0 - beyond, beyond - g1) * scales[a];
    difference[a][0] = select(upper, there, here);
    difference[a][1] = select(upper, here, there);
  }
  Vec3 sum{Float(0.0f), Float(0.0f), Float(0.0f)};
  for (int i = 0; i < 8; ++i) {
    Float weight(1.0f);
    Mask exists = active;
    for (int a = 0; a < 3; ++a) {
      const Mask outside = low[a] < 0;
      const bool high = i >> a & 1;
      const Float t = select(outside, Float(1.0f), blend[a]);
      weight = weight * (high ? t : 1.0f - t);
      if (!high) exists = and_not(exists, outside);
    }
    const Vec3 n = normalize(Vec3{difference[0][i & 1], difference[1][i >> 1 & 1], difference[2][i >> 2]});
    sum = select(exists, sum + n * weight, sum);
  }
  return sum;
}

const SdfGridRecord& grid_of(const ShapeTable& table, const ShapeRecord& shape) {
  return table.sdf_grids[static_cast<std::size_t>(shape.quadric)];
}

/// The zero level of a grid of distances; its primitives are the voxels that hold a piece of it.
class SdfGridShape final : public AnalyticShape {
 public:
  std::int32_t primitive_count(const ShapeTable& table, const ShapeRecord& shape) const override {
    return static_cast<std::int32_t>(grid_of(table, shape).voxels.size());
  }

  ShapeBounds bounds(const ShapeTable& table, const ShapeRecord& shape,
                     std::int32_t primitive) const override {
    const SdfGridRecord& grid = grid_of(table, shape);
    const std::int32_t lower = grid.voxels[static_cast<std::size_t>(primitive)];
    const std::int32_t at[3] = {lower % grid.size[0], lower / grid.size[0] % grid.size[1],
                                lower / grid.size[0] / grid.size[1]};
    float centre[3], half[3];
    for (int i = 0; i < 3; ++i) {
      half[i] = 0.5f / static_cast<float>(grid.size[i] - 1);
      centre[i] = (2 * static_cast<float>(at[i]) + 1) * half[i];
    }
    return placed_bounds(grid.render_from_object, centre, half);
  }

  Float nearest(const ShapeTable& table, const ShapeRecord& shape, std::int32_t primitive,
                const ShapeRays& rays) const override {
    const SdfGridRecord& grid = grid_of(table, shape);
    const Int lower(grid.voxels[static_cast<std::size_t>(primitive)]);
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
  }

  void surface(const ShapeTable& table, const ShapeRecord& shape, const Hit& hit, Vec3 o, Vec3 d, Mask active,
               bool, Surface& s) const override {
    const SdfGridRecord& grid = grid_of(table, shape);
    const Vec3 scale = sdf_scale(grid);
    const Vec3 guess =
        transform_point(grid.object_from_render, o) + transform_vector(grid.object_from_render, d) * hit.t;
    const Int lower = gather(grid.voxels.data(), hit.primitive, active);
    const SdfVoxel voxel(grid, lower, active);
    const Vec3 corner = voxel_position(grid, lower);
    Vec3 local = scaled(guess, scale) - corner;
    // One step of Newton's method along the gradient takes off the error of t.
    const Vec3 slope = voxel.gradient(local);
    local = local - slope * (voxel.value(local) / max(length_squared(slope), 1e-30f));

    const Vec3 in_grid = local + corner;
    const Vec3 in_object{in_grid.x / scale.x, in_grid.y / scale.y, in_grid.z / scale.z};
    const Vec3 gradient = scaled(voxel.gradient(local), scale);
    const Vec3 p = transform_point(grid.render_from_object, in_object);
    Vec3 ng = normalize(transform_normal(grid.object_from_render, gradient));
    Vec3 ns = ng;
    if (grid.smooth_normals) {
      ns = face_forward(
          normalize(transform_normal(grid.object_from_render, smooth_gradient(grid, in_grid, active))), ng);
    }
    if (shape.flags & kFlipNormal) ng = -ng, ns = -ns;

    const auto& m = grid.render_from_object.m;
    const Vec3 spread = transform_vector(grid.render_from_object, {Float(1.0f), Float(1.0f), Float(1.0f)});
    const Float extent = largest_coordinate(p) + largest_coordinate(spread) + std::abs(m[3]) +
                         std::abs(m[7]) + std::abs(m[11]);
    s.p = select(active, p, s.p);
    s.error = select(active, along_normal(ng, extent * (4 * kPositionError)), s.error);
    s.ng = select(active, ng, s.ng);
    s.ns = select(active, ns, s.ns);
    const Frame frame = Frame::from_normal(ns);
    s.dpdu = select(active, frame.x, s.dpdu);
    s.dpdv = select(active, frame.y, s.dpdv);
  }
};

}  // namespace

const ModelOf<SdfGridShape> sdf_grid(ShapeKind::kSdfGrid);

}  // namespace tessera::render::TESSERA_ISA
