#include "render/shape/sdf_surface.h"

#include "render/core/affine.h"
#include "render/shape/error_bound.h"
#include "render/shape/sdf_voxel.h"

namespace tessera::render::TESSERA_ISA {

namespace {

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

}  // namespace

void sdf_surface(const ShapeTable& table, const ShapeRecord& shape, const Hit& hit, Vec3 o, Vec3 d,
                 Mask active, Surface& s) {
  const SdfGridRecord& grid = table.sdf_grids[static_cast<std::size_t>(shape.quadric)];
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
  const Float extent =
      largest_coordinate(p) + largest_coordinate(spread) + std::abs(m[3]) + std::abs(m[7]) + std::abs(m[11]);
  s.p = select(active, p, s.p);
  s.error = select(active, along_normal(ng, extent * (4 * kPositionError)), s.error);
  s.ng = select(active, ng, s.ng);
  s.ns = select(active, ns, s.ns);
  const Frame frame = Frame::from_normal(ns);
  s.dpdu = select(active, frame.x, s.dpdu);
  s.dpdv = select(active, frame.y, s.dpdv);
}

}  // namespace tessera::render::TESSERA_ISA
