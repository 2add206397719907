#include <algorithm>
#include <cmath>

#include "render/core/affine.h"
#include "render/core/constants.h"
#include "render/shape/error_bound.h"
#include "render/shape/implicit/implicit_search.h"

namespace tessera::render::TESSERA_ISA {
namespace {

const ImplicitRecord& record_of(const ShapeTable& table, const ShapeRecord& shape) {
  return table.implicits[static_cast<std::size_t>(shape.quadric)];
}

double size_of(const ImplicitRecord& surface) {
  double size = 0;
  for (int a = 0; a < 3; ++a) size = std::max(size, double{surface.high[a]} - double{surface.low[a]});
  return size;
}

Vec3 to_vec(const Point3& p) { return {p.x.to_float(), p.y.to_float(), p.z.to_float()}; }
Point3 plus(const Point3& p, const Point3& v, Double t) {
  return {fma(v.x, t, p.x), fma(v.y, t, p.y), fma(v.z, t, p.z)};
}
Point3 select(DoubleMask m, const Point3& a, const Point3& b) {
  return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
}

Point3 gradient_at(const ImplicitRecord& surface, const Point3& p) {
  const Double zero(0.0), one(1.0);
  using Number = Dual<Double, 3>;
  const Number f = run_program(surface.program, Number{p.x, {one, zero, zero}},
                               Number{p.y, {zero, one, zero}}, Number{p.z, {zero, zero, one}});
  return {f.d[0], f.d[1], f.d[2]};
}

/// The hit in double precision: `t`, a float, may be half a size off for rays that come from afar. The root
/// is found again in what its rounding leaves.
Point3 point_on_surface(const ImplicitRecord& surface, Vec3 o, Vec3 d, Float t, Mask active) {
  const Double middle(t), off = fma(abs(middle), Double(0x1p-22), Double(1e-38));
  const ObjectChord chord = chord_within(surface, o, d, middle - off, middle + off, active);
  Double root = roots_between_signs(surface, chord);
  // The nearest root is taken where there are several, or the surface is touched.
  ObjectChord rest = chord;
  rest.meets = and_not(chord.meets, mask_of(root >= chord.begin));
  if (any(rest.meets)) root = select(double_mask_of(rest.meets), first_roots(surface, rest, false), root);
  // A ray that begins within a rounding of the surface has a root behind it.
  return chord.at(select(root >= chord.begin, root, middle));
}

/// Perpendicular to the surface, unit. Where the gradient vanishes (nodes, double roots) it is that of a
/// place on the ray a little before; where that vanishes too, the normal faces the ray.
Point3 normal_at(const ImplicitRecord& surface, const Point3& p, const Point3& d, Mask active) {
  const Double way(size_of(surface) * 0x1p-10), most(1e280), least(1e-280), far_less(0x1p-12);
  const Point3 back = plus(p, d, -way / length_of(d)), here = gradient_at(surface, p);
  const Double steep = length_of(here);
  const auto usable = [&](Double a) { return (a > least) & (a < most); };
  // The rise of f on the way there tells, with less work than another gradient, whether this one vanishes.
  DoubleMask regular = usable(steep) & (steep > abs(value_at(surface, back)) / way * far_less);
  Point3 n = here;
  if (any(and_not(active, mask_of(regular)))) {
    const Point3 before = gradient_at(surface, back);
    const Double steep_before = length_of(before);
    regular = regular | (usable(steep) & (steep > steep_before * far_less));
    n = select(regular, here, select(usable(steep_before), before, {-d.x, -d.y, -d.z}));
  }
  const Double inverse = Double(1.0) / length_of(n);
  return {n.x * inverse, n.y * inverse, n.z * inverse};
}

/// `error`, or as much more as it takes to get along `step` to where f is known to be other than zero.
Float clear_of_zero(const ImplicitRecord& surface, const Point3& p, const Point3& step, Float error,
                    Mask active) {
  const Double floor = noise_floor(surface, p);
  for (int i = 0; i < 16; ++i) {
    const Double e(error);
    const Double above = abs(value_at(surface, plus(p, step, e))),
                 below = abs(value_at(surface, plus(p, step, -e)));
    const Mask close = active & mask_of(min(above, below) <= floor);
    if (none(close)) break;
    error = select(close, 2.0f * error, error);
  }
  return error;
}

/// Parameters of a sphere about the middle of the bounds, as those of kSphere, and tangents along them.
void set_parameters(const ImplicitRecord& surface, const Point3& p, Vec3 n, Mask active, bool want_tangents,
                    Surface& s) {
  const auto from_middle = [&](Double x, int a) {
    return (x - Double(0.5 * (double{surface.low[a]} + double{surface.high[a]}))).to_float();
  };
  const Vec3 q{from_middle(p.x, 0), from_middle(p.y, 1), from_middle(p.z, 2)};
  const Float phi = atan2(q.y, q.x), r2 = length_squared(q), rho2 = sqr(q.x) + sqr(q.y), rho = sqrt(rho2);
  const Float cosine = clamp(q.z / sqrt(max(r2, 1e-37f)), -1.0f, 1.0f);
  s.uv.x = select(active, select(phi < 0.0f, phi + 2 * kPi, phi) * (0.5f / kPi), s.uv.x);
  s.uv.y = select(active, 1.0f - acos(cosine) * (1 / kPi), s.uv.y);
  if (!want_tangents) return;
  // dp/du is the way in the tangent plane along which v stands still: both are products of gradients.
  const Float across = 1.0f / max(rho, 1e-18f), inverse = 1.0f / max(r2, 1e-36f);
  const Vec3 du = Vec3{-q.y * across, q.x * across, Float(0.0f)} * (across * (0.5f / kPi));
  const Vec3 dv = Vec3{-q.x * q.z * across, -q.y * q.z * across, rho} * (inverse * (1 / kPi));
  const Float area = dot(n, cross(du, dv));
  const Mask usable = (abs(area) > 1e-6f * length(du) * length(dv)) & (rho2 > 1e-30f);
  const Float scale = 1.0f / select(usable, area, 1.0f);
  const Frame frame = Frame::from_normal(n);
  const auto place = [&](Vec3 v) { return transform_vector(surface.render_from_object, v); };
  s.dpdu = select(active, place(select(usable, cross(dv, n) * scale, frame.x)), s.dpdu);
  s.dpdv = select(active, place(select(usable, cross(n, du) * scale, frame.y)), s.dpdv);
}

/// The zero set of a function within bounds; one primitive.
class ImplicitShape final : public AnalyticShape {
 public:
  ShapeBounds bounds(const ShapeTable& table, const ShapeRecord& shape, std::int32_t) const override {
    const ImplicitRecord& surface = record_of(table, shape);
    float centre[3], half[3];
    for (int i = 0; i < 3; ++i) {
      centre[i] = 0.5f * (surface.low[i] + surface.high[i]);
      half[i] = 0.5f * (surface.high[i] - surface.low[i]);
    }
    return placed_bounds(surface.render_from_object, centre, half);
  }

  Float nearest(const ShapeTable& table, const ShapeRecord& shape, std::int32_t,
                const ShapeRays& rays) const override {
    return root_within(record_of(table, shape), rays, false);
  }

  Mask occluded(const ShapeTable& table, const ShapeRecord& shape, std::int32_t,
                const ShapeRays& rays) const override {
    return rays.active & (root_within(record_of(table, shape), rays, true) >= 0.0f);
  }

  void crossings(const ShapeTable& table, const ShapeRecord& shape, std::int32_t, const ExactRay& ray,
                 std::vector<double>& found) const override {
    const ImplicitRecord& surface = record_of(table, shape);
    all_roots_by_enclosure(surface, chord_of(surface, ray), found);
  }

  void surface(const ShapeTable& table, const ShapeRecord& shape, const Hit& hit, Vec3 o, Vec3 d, Mask active,
               bool want_tangents, Surface& s) const override {
    const ImplicitRecord& surface = record_of(table, shape);
    const Affine &to = surface.render_from_object, &from = surface.object_from_render;
    const Point3 in_object = point_on_surface(surface, o, d, hit.t, active);
    const Vec3 n = to_vec(normal_at(surface, in_object, place_in_object(from, d, 0).value, active));
    const auto row = [&](int i) {
      return fma(in_object.x, Double(to.m[i]),
                 fma(in_object.y, Double(to.m[i + 1]),
                     fma(in_object.z, Double(to.m[i + 2]), Double(to.m[i + 3]))))
          .to_float();
    };
    const Vec3 p{row(0), row(4), row(8)};
    Vec3 ng = normalize(transform_normal(from, n));
    if (shape.flags & kFlipNormal) ng = -ng;

    // The transform's own roundings count: the extent of the object about its origin, seen in render space.
    float spread = 0;
    for (int i = 0; i < 3; ++i) {
      float reach = std::abs(to.m[4 * i + 3]);
      for (int a = 0; a < 3; ++a)
        reach += std::abs(to.m[4 * i + a]) * std::max(std::abs(surface.low[a]), std::abs(surface.high[a]));
      spread = std::max(spread, reach);
    }
    const Float error = along_normal(ng, (largest_coordinate(p) + spread) * kPositionError);
    s.p = select(active, p, s.p);
    s.error =
        select(active, clear_of_zero(surface, in_object, place_in_object(from, ng, 0).value, error, active),
               s.error);
    s.ng = select(active, ng, s.ng);
    s.ns = select(active, ng, s.ns);
    set_parameters(surface, in_object, n, active, want_tangents, s);
  }

 private:
  static Float root_within(const ImplicitRecord& surface, const ShapeRays& rays, bool any) {
    const ObjectChord chord =
        chord_within(surface, rays.o, rays.d, Double(rays.t_near), Double(rays.t_far), rays.active);
    if (none(chord.meets)) return Float(-1.0f);
    const Double root = first_roots(surface, chord, any);
    const Mask found = chord.meets & mask_of(root >= chord.begin);
    if (any) return select(found, 1.0f, Float(-1.0f));
    const Float t = root.to_float();
    return select(found & (t > rays.t_near) & (t < rays.t_far), t, -1.0f);
  }
};

}  // namespace

const ModelOf<ImplicitShape> implicit(ShapeKind::kImplicit);

}  // namespace tessera::render::TESSERA_ISA
