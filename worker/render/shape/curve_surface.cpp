#include "render/shape/curve_surface.h"

#include "render/core/constants.h"
#include "render/shape/error_bound.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// A control point or a point of the curve: where, and how thick there.
struct Knot {
  Vec3 p;
  Float radius;
};

Knot operator+(Knot a, Knot b) { return {a.p + b.p, a.radius + b.radius}; }
Knot operator*(Knot a, float s) { return {a.p * Float(s), a.radius * s}; }
Knot fma(Knot a, float s, Knot b) { return {fma(a.p, s, b.p), fma(a.radius, s, b.radius)}; }
Knot lerp(Float t, Knot a, Knot b) { return {fma(b.p - a.p, t, a.p), lerp(t, a.radius, b.radius)}; }

struct Segment {
  Knot b[4];                 // Bezier control points
  Float size = Float(0.0f);  // of curves that deform: coordinates that the points are computed from
};

/// The Bezier points of one segment of a uniform cubic B-spline.
void to_bezier(Segment& s) {
  const Knot p0 = s.b[0], p1 = s.b[1], p2 = s.b[2], p3 = s.b[3];
  s.b[0] = (fma(p1, 4.0f, p0) + p2) * (1.0f / 6);
  s.b[1] = fma(p1, 2.0f, p2) * (1.0f / 3);
  s.b[2] = fma(p2, 2.0f, p1) * (1.0f / 3);
  s.b[3] = (fma(p2, 4.0f, p1) + p3) * (1.0f / 6);
}

Knot read_knot(const CurvesRecord& record, Int index, Mask active) {
  const Float4 point = gather4(record.points.data()->position, index * 4, active);
  return {{point.c[0], point.c[1], point.c[2]}, point.c[3]};
}

Segment read_segment(const CurvesRecord& record, Int start, Float time, Mask active) {
  Segment s;
  if (record.key_segments == 0) {
    for (int k = 0; k < 4; ++k) s.b[k] = read_knot(record, start + k, active);
  } else {
    // Linear between two keys, as in Embree.
    const Float place = select_or_zero(active, time) * static_cast<float>(record.key_segments);
    const Int before = max(min(to_int(place), record.key_segments - 1), 0);
    const auto count = static_cast<std::int32_t>(record.points.size()) / (record.key_segments + 1);
    for (int k = 0; k < 4; ++k) {
      const Int index = before * count + start + k;
      const Knot a = read_knot(record, index, active), b = read_knot(record, index + count, active);
      s.b[k] = lerp(place - to_float(before), a, b);
      s.size = max(s.size, max(largest_coordinate(a.p), largest_coordinate(b.p)));
    }
  }
  if (record.bspline) to_bezier(s);
  return s;
}

/// The point at u by de Casteljau, and dp/du, which is never zero.
Knot evaluate(const Segment& s, Float u, Vec3& dpdu) {
  const Knot a = lerp(u, s.b[0], s.b[1]), b = lerp(u, s.b[1], s.b[2]), c = lerp(u, s.b[2], s.b[3]);
  const Knot ab = lerp(u, a, b), bc = lerp(u, b, c);
  dpdu = (bc.p - ab.p) * Float(3.0f);
  // Where control points coincide: along the chord, or anywhere.
  const Vec3 chord = s.b[3].p - s.b[0].p;
  dpdu = select(length_squared(dpdu) > 1e-14f * length_squared(chord), dpdu, chord);
  const Vec3 z{Float(0.0f), Float(0.0f), Float(1.0f)};
  dpdu = select(length_squared(dpdu) > 0.0f, dpdu, z);
  return lerp(u, ab, bc);
}

/// The ribbon's normal at u, turned to the viewer's side of the ribbon.
Vec3 ribbon_normal(const CurvesRecord& record, Int start, Float u, Vec3 tangent, Vec3 w, Mask active) {
  Segment s;
  for (int k = 0; k < 4; ++k) {
    const Float4 n = gather4(record.normals.data(), (start + k) * 3, active);
    s.b[k] = {{n.c[0], n.c[1], n.c[2]}, Float(0.0f)};
  }
  if (record.bspline) to_bezier(s);
  Vec3 unused;
  const Vec3 n = evaluate(s, u, unused).p;
  return face_forward(fma(-tangent, dot(n, tangent), n), w);
}

}  // namespace

void curve_surface(const CurvesRecord& record, const Hit& hit, Vec3 o, Vec3 d, Mask active, Surface& s) {
  const auto* starts = reinterpret_cast<const std::int32_t*>(record.starts.data());
  const Int start = gather(starts, hit.primitive, active);
  const Float u = clamp(hit.u, 0.0f, 1.0f);
  Vec3 dpdu;
  const Segment segment = read_segment(record, start, hit.time, active);
  const Knot axis = evaluate(segment, u, dpdu);
  const Vec3 tangent = normalize(dpdu), w = -normalize(d);

  const bool ribbon = record.kind == CurveKind::kRibbon;
  Vec3 ng = ribbon ? ribbon_normal(record, start, u, tangent, w, active) : fma(-tangent, dot(w, tangent), w);
  // A ray along the curve sees no side of it in particular.
  const Float l2 = length_squared(ng);
  ng = select(l2 > 1e-12f, normalize(ng), Frame::from_normal(tangent).x);
  const Vec3 across = cross(ng, tangent);

  // The offset of the ray from the axis: for what faces the ray the same all along it, and so without the
  // error of t.
  const Vec3 from_axis = o - axis.p;
  const Float offset = dot(ribbon ? fma(d, hit.t, from_axis) : from_axis, across);
  const Float radius = max(axis.radius, 0.0f);
  const Float h = clamp(offset / max(radius, 1e-30f), -1.0f, 1.0f);
  const Vec3 p = fma(across, h * radius, axis.p);

  // The normal of a cylinder fans out over half a turn, in equal steps across the width [pbrt-v4].
  Vec3 ns = ng, side = across;
  if (record.kind == CurveKind::kCylinder) {
    const Float angle = h * (kPi / 2), c = cos(angle), si = sin(angle);
    ns = fma(ng, c, across * si);
    side = fma(across, c, ng * -si);
  }

  Float u_first(0.0f), u_last(1.0f);
  if (!record.params.empty()) {
    u_first = gather(record.params.data(), hit.primitive * 2, active);
    u_last = gather(record.params.data() + 1, hit.primitive * 2, active);
  }
  // Rays leave a flat curve from two widths off it, so that they do not meet the same curve turned their way
  // [pbrt-v4].
  const Float extent = largest_coordinate(axis.p) + radius + segment.size;
  s.p = select(active, p, s.p);
  s.error = select(active, along_normal(ng, extent * kPositionError + (ribbon ? Float(0.0f) : radius * 4.0f)),
                   s.error);
  s.ng = select(active, ng, s.ng);
  s.ns = select(active, ns, s.ns);
  s.uv = {select(active, lerp(u, u_first, u_last), s.uv.x), select(active, h * 0.5f + 0.5f, s.uv.y)};
  s.dpdu = select(active, dpdu, s.dpdu);
  s.dpdv = select(active, side * (radius * 2.0f), s.dpdv);
}

}  // namespace tessera::render::TESSERA_ISA
