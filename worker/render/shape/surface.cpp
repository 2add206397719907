#include "render/shape/surface.h"

#include <cstddef>
#include <optional>

#include "render/core/affine.h"
#include "render/core/motion.h"
#include "render/shape/analytic_shape.h"
#include "render/shape/curve_surface.h"
#include "render/shape/error_bound.h"
#include "render/shape/place.h"
#include "render/shape/triangle_normal.h"
#include "render/shape/vertex_lanes.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// dp/du and dp/dv of a triangle; an arbitrary frame where its uvs are degenerate.
void triangle_tangents(Vec3 e1, Vec3 e2, Vec2 duv1, Vec2 duv2, Vec3 ng, Vec3& dpdu, Vec3& dpdv) {
  const Float det = difference_of_products(duv1.x, duv2.y, duv1.y, duv2.x);
  const Mask usable = abs(det) > 1e-12f;
  const Float inv = 1.0f / select(usable, det, 1.0f);
  const Frame fallback = Frame::from_normal(ng);
  dpdu = select(usable, fma(e1, duv2.y, e2 * -duv1.y) * inv, fallback.x);
  dpdv = select(usable, fma(e2, duv1.x, e1 * -duv2.x) * inv, fallback.y);
}

/// Four neighbouring members of ShapeRecords, from the one at `first` on.
TESSERA_INLINE Int4 gather_row(const ShapeTable& table, int first, Int shape, Mask active) {
  constexpr int kStride = sizeof(ShapeRecord) / 4;
  return gather4(reinterpret_cast<const std::int32_t*>(table.shapes.data()) + first, shape * kStride, active);
}

/// Weights of a triangle's second and third vertex where a ray meets it [Moller1997], with a division that
/// rounds alike on every machine: Embree's are found with an approximate one
/// (docs/decisions/0019-arithmetic-classes.md). `from_ray` leads from the first vertex to a point of the ray,
/// `normal` is cross(e1, e2). Embree's stand where the ray lies in the triangle's plane.
TESSERA_INLINE Vec2 exact_weights(Vec3 e1, Vec3 e2, Vec3 normal, Vec3 from_ray, Vec3 d, Vec2 approximate) {
  const Vec3 moment = cross(d, from_ray);
  const Float inverse = 1.0f / dot(d, normal);
  const Float u = dot(e2, moment) * inverse, v = -dot(e1, moment) * inverse;
  const Mask usable = is_finite(u + v);
  // On the triangle, whatever was rounded away: the error bound counts on it.
  const Float b1 = clamp(u, 0.0f, 1.0f), b2 = min(max(v, 0.0f), 1.0f - b1);
  return {select(usable, b1, approximate.x), select(usable, b2, approximate.y)};
}

TESSERA_INLINE void triangle_surface(const ShapeTable& table, const Hit& hit, Int flags, Vec3 o, Vec3 d,
                                     Mask active, bool want_tangents, Surface& s) {
  const Int4 range = gather_row(table, offsetof(ShapeRecord, first_triangle) / 4, hit.shape, active);
  static_assert(offsetof(ShapeRecord, first_vertex) == offsetof(ShapeRecord, first_triangle) + 4);
  const Int first_triangle = range.c[0];
  Int first_vertex = range.c[1];
  // The row of the last triangle ends beyond the array, which may be read.
  const auto* indices = reinterpret_cast<const std::int32_t*>(table.triangles.data());
  const Int4 corners = gather4(indices, (first_triangle + hit.primitive) * 3, active);

  const Mask deforming = active & ((flags & kDeforms) != 0);
  std::optional<KeyLanes> key;
  if (any(deforming)) {
    key.emplace(table, hit.shape, hit.time, deforming);
    first_vertex = first_vertex + key->before * key->vertices;
  }
  VertexLanes v0(table, first_vertex + corners.c[0], active), v1(table, first_vertex + corners.c[1], active),
      v2(table, first_vertex + corners.c[2], active);
  const bool reads_rest = any(active & ((flags & (kHasNormals | kHasUvs)) != 0));
  if (reads_rest) {
    for (VertexLanes* v : {&v0, &v1, &v2}) v->read_rest();
  }
  Float keys_size(0.0f);  // the largest coordinate of the keys that a place is computed from
  if (key) {
    int corner = 0;
    for (VertexLanes* v : {&v0, &v1, &v2}) {
      VertexLanes next(table, first_vertex + key->vertices + corners.c[corner++], deforming);
      keys_size = max(keys_size, v->mix_position(next, key->part, deforming));
      if (!reads_rest) continue;
      next.read_rest();
      v->mix_normal(next, key->part, deforming);
    }
  }
  const Vec3 p0 = v0.position(), p1 = v1.position(), p2 = v2.position();
  const Vec3 e1 = p1 - p0, e2 = p2 - p0;
  const Float size = max(largest_coordinate(e1), largest_coordinate(e2)), scale = scale_of_sides(size);
  const Vec3 across = cross(e1 * scale, e2 * scale), ng = normalize(across);
  const Vec2 weights = exact_weights(e1 * scale, e2 * scale, across, (o - p0) * scale, d, {hit.u, hit.v});
  const Float b1 = weights.x, b2 = weights.y, b0 = 1.0f - b1 - b2;
  const Vec3 p = fma(p2, b2, fma(p1, b1, p0 * b0));

  // Shading normal; one that degenerates or turns away is replaced or turned.
  const Mask with_normals = active & ((flags & kHasNormals) != 0);
  Vec3 ns = ng;
  if (any(with_normals)) {
    const Vec3 n = fma(v2.normal(), b2, fma(v1.normal(), b1, v0.normal() * b0));
    const Float l2 = length_squared(n);
    const Mask usable = with_normals & (l2 > 0.0f) & is_finite(l2);
    ns = face_forward(select(usable, normalize(n), ng), ng);
  }

  // pbrt's default parameterisation where a mesh has none: (0,0), (1,0), (1,1).
  const Mask with_uvs = active & ((flags & kHasUvs) != 0);
  Vec2 uv0{Float(0.0f), Float(0.0f)}, uv1{Float(1.0f), Float(0.0f)}, uv2{Float(1.0f), Float(1.0f)};
  if (any(with_uvs)) {
    const auto own_or = [&](Vec2 own, Vec2 otherwise) {
      return Vec2{select(with_uvs, own.x, otherwise.x), select(with_uvs, own.y, otherwise.y)};
    };
    uv0 = own_or(v0.uv(), uv0);
    uv1 = own_or(v1.uv(), uv1);
    uv2 = own_or(v2.uv(), uv2);
  }

  const Float extent = largest_coordinate(p) + size + keys_size;
  s.p = select(active, p, s.p);
  s.error = select(active, along_normal(ng, extent * kPositionError), s.error);
  s.barycentric = {select(active, b1, s.barycentric.x), select(active, b2, s.barycentric.y)};
  s.ng = select(active, ng, s.ng);
  s.ns = select(active, ns, s.ns);
  s.uv.x = select(active, fma(b0, uv0.x, fma(b1, uv1.x, b2 * uv2.x)), s.uv.x);
  s.uv.y = select(active, fma(b0, uv0.y, fma(b1, uv1.y, b2 * uv2.y)), s.uv.y);
  if (want_tangents) {
    Vec3 dpdu, dpdv;
    triangle_tangents(e1, e2, {uv1.x - uv0.x, uv1.y - uv0.y}, {uv2.x - uv0.x, uv2.y - uv0.y}, ng, dpdu, dpdv);
    s.dpdu = select(active, dpdu, s.dpdu);
    s.dpdv = select(active, dpdv, s.dpdv);
  }
}

/// Where instances are.
struct Placement {
  WideAffine to, from;  // instance space to render space, and back
  Float shift;          // size of the coordinates of the translation
};

/// Where objects within objects are: each lane by itself, in double.
Placement nested_placement(const ShapeTable& table, const Hit& hit, Mask placed) {
  alignas(64) std::int32_t instance[kWidth], upper[kWidth];
  alignas(64) float time[kWidth], to[12][kWidth] = {}, from[12][kWidth] = {}, shift[kWidth] = {};
  hit.instance.store(instance), hit.upper.store(upper), hit.time.store(time);
  for (std::uint32_t bits = placed.bits(); bits != 0; bits &= bits - 1) {
    const int lane = __builtin_ctz(bits);
    const PlaceMap map = map_of_place(table, place_number(instance[lane], upper[lane]), time[lane]);
    const ExactAffine back = inverse(map.render_from_object);
    for (int i = 0; i < 12; ++i) {
      to[i][lane] = static_cast<float>(map.render_from_object.m[i]);
      from[i][lane] = static_cast<float>(back.m[i]);
    }
    shift[lane] = static_cast<float>(map.shift);
  }
  Placement at;
  for (int i = 0; i < 12; ++i) at.to.m[i] = Float::load(to[i]), at.from.m[i] = Float::load(from[i]);
  at.shift = Float::load(shift);
  return at;
}

Placement placement_at(const ShapeTable& table, Int instance, Float time, Mask placed) {
  const InstanceRecord* instances = table.instances.data();
  const auto* base = reinterpret_cast<const float*>(instances);
  constexpr int kStride = sizeof(InstanceRecord) / sizeof(float);
  Int segments(0);
  if (!table.motion_steps.empty())
    segments = gather_member(instances, &InstanceRecord::segments, instance, placed);
  const Mask moving = placed & (segments > 0), still = and_not(placed, moving);
  Placement at;
  for (int i = 0; i < 12; ++i) at.to.m[i] = at.from.m[i] = Float(0.0f);
  if (any(still)) {
    for (int i = 0; i < 12; ++i) {
      at.to.m[i] = gather(base + i, instance * kStride, placed);
      at.from.m[i] = gather(base + 12 + i, instance * kStride, placed);
    }
  }
  at.shift = largest_coordinate({at.to.m[3], at.to.m[7], at.to.m[11]});
  if (none(moving)) return at;
  const Int first = gather_member(instances, &InstanceRecord::first_step, instance, moving);
  const MovedAffine moved = affine_at(table.motion_steps.data(), first, segments, time, moving);
  const WideAffine back = inverse(moved.map);
  for (int i = 0; i < 12; ++i) {
    at.to.m[i] = select(moving, moved.map.m[i], at.to.m[i]);
    at.from.m[i] = select(moving, back.m[i], at.from.m[i]);
  }
  at.shift = select(moving, moved.shift, at.shift);
  return at;
}

/// Instance space to render space.
void place_instances(const Placement& at, Mask placed, bool want_tangents, Surface& s) {
  const WideAffine &to = at.to, &from = at.from;
  const Vec3 p = transform_point(to, s.p);
  const Float growth =
      largest_coordinate(abs(Vec3{to.m[0], to.m[4], to.m[8]}) + abs(Vec3{to.m[1], to.m[5], to.m[9]}) +
                         abs(Vec3{to.m[2], to.m[6], to.m[10]}));
  const Vec3 ng = normalize(transform_normal(from, s.ng));
  const Float extent = largest_coordinate(p) + largest_coordinate(s.p) * growth + at.shift;
  s.error = select(placed, s.error * growth + along_normal(ng, extent * kPositionError), s.error);
  s.p = select(placed, p, s.p);
  s.ng = select(placed, ng, s.ng);
  s.ns = select(placed, normalize(transform_normal(from, s.ns)), s.ns);
  if (want_tangents) {
    s.dpdu = select(placed, transform_vector(to, s.dpdu), s.dpdu);
    s.dpdv = select(placed, transform_vector(to, s.dpdv), s.dpdv);
  }
}

}  // namespace

Surface surface_at(const ShapeTable& table, const Hit& hit, Vec3 o, Vec3 d, Mask active, bool want_tangents) {
  static_assert(offsetof(ShapeRecord, kind) == 0 && offsetof(ShapeRecord, material) == 4 &&
                offsetof(ShapeRecord, flags) == 8 && offsetof(ShapeRecord, first_light) == 12);
  const Vec3 zero{Float(0.0f), Float(0.0f), Float(0.0f)};
  Surface s{zero,          Float(0.0f),   zero,   zero,    {Float(0.0f), Float(0.0f)},
            zero,          zero,          Int(0), Int(-1), hit.shape,
            hit.primitive, {hit.u, hit.v}};
  if (none(active)) return s;  // the table may be empty, which nothing can be read from
  const Int4 what = gather_row(table, 0, hit.shape, active);
  const Int kind = what.c[0], flags = what.c[2], first_light = what.c[3];
  s.material = select_or_zero(active, what.c[1]);
  s.light = select(active & (first_light >= 0), first_light + hit.primitive, Int(-1));
  const Mask triangles = active & (kind == static_cast<std::int32_t>(ShapeKind::kTriangles));
  const Mask placed = active & (hit.instance >= 0);
  Placement placement;
  Vec3 io = o, id = d;
  if (any(placed)) {
    placement = table.nested() ? nested_placement(table, hit, placed)
                               : placement_at(table, hit.instance, hit.time, placed);
    io = select(placed, transform_point(placement.from, o), o);
    id = select(placed, transform_vector(placement.from, d), d);
  }
  if (any(triangles)) triangle_surface(table, hit, flags, io, id, triangles, want_tangents, s);
  const Mask others = and_not(active, triangles);
  if (any(others)) {
    for_each_distinct(hit.shape, others, [&](std::int32_t shape, Mask lanes) {
      const ShapeRecord& record = table.shapes[static_cast<std::size_t>(shape)];
      if (const AnalyticShape* const model = analytic_shape(record.kind)) {
        model->surface(table, record, hit, io, id, lanes, want_tangents, s);
      } else {
        curve_surface(table.curves[static_cast<std::size_t>(record.quadric)], hit, io, id, lanes, s);
      }
    });
  }
  if (any(placed)) place_instances(placement, placed, want_tangents, s);
  return s;
}

}  // namespace tessera::render::TESSERA_ISA
