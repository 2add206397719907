#include <cmath>

#include "render/shape/double_ray.h"
#include "render/shape/round_form.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// Azimuth and height limits.
Mask inside_limits(const QuadricRecord& q, Vec3 p) {
  if (!q.partial) return Mask::all();
  Mask inside = azimuth(p) <= q.phi_max;
  if (q.z_min > -q.radius) inside &= p.z >= q.z_min;
  if (q.z_max < q.radius) inside &= p.z <= q.z_max;
  return inside;
}

constexpr RoundForm kForm{
    .is_solid = [](const QuadricRecord& q) { return !q.partial; },
    .contains =
        [](const QuadricRecord& q, const double (&p)[3]) {
          return p[0] * p[0] + p[1] * p[1] + p[2] * p[2] < double{q.radius} * q.radius;
        },
    .support =
        [](const QuadricRecord& q, const double (&a)[3]) {
          return double{q.radius} * std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
        },
    .profile = [](const QuadricRecord& q) -> std::vector<ProfilePiece> {
      return {{.ax = 0, .az = 0, .bx = 0, .bz = 0, .radius = q.radius, .z_low = q.z_min, .z_high = q.z_max}};
    }};

/// A sphere about the origin, perhaps cut by two heights and an azimuth.
///
/// The discriminant is that of the distance from the centre to the ray [Hearn & Baker; Haines et al. 2019].
/// The nearest point is found twice, the second time from the first, so that it does not cancel for far or
/// tiny spheres.
class SphereShape final : public QuadricShape {
 public:
  const RoundForm* round_form() const override { return &kForm; }
  ShapeBounds bounds(const ShapeTable& table, const ShapeRecord& shape, std::int32_t) const override {
    const QuadricRecord& q = table.quadrics[static_cast<std::size_t>(shape.quadric)];
    return placed_bounds(q.render_from_object, {0, 0, (q.z_min + q.z_max) / 2},
                         {q.radius, q.radius, (q.z_max - q.z_min) / 2});
  }
  int spans(const ShapeTable& table, const ShapeRecord& shape, const DoubleRay& ray,
            SolidSpans& found) const override {
    const double radius = table.quadrics[static_cast<std::size_t>(shape.quadric)].radius;
    const Double *const o = ray.o, *const d = ray.d;
    const Double left = radius * radius - (o[0] * o[0] + o[1] * o[1] + o[2] * o[2]);
    const Double half = square_root(upper(left / (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]), splat(0.0)));
    found.enter[0] = -half, found.leave[0] = half;
    return 1;
  }
  void crossings(const ShapeTable& table, const ShapeRecord& shape, std::int32_t, const ExactRay& ray,
                 std::vector<double>& found) const override {
    const QuadricRecord& q = table.quadrics[static_cast<std::size_t>(shape.quadric)];
    const ExactObjectRay r(q.object_from_render, ray);
    double oo = 0, dd = 0;
    for (int i = 0; i < 3; ++i) oo += r.o[i] * r.o[i], dd += r.d[i] * r.d[i];
    const double discriminant = double{q.radius} * q.radius - oo;
    if (!(discriminant >= 0)) return;
    const double half_chord = std::sqrt(discriminant / dd);
    for (const double s : {-half_chord, half_chord}) {
      const double z = r.at(2, s);
      const bool cut = q.partial && (azimuth(r.at(0, s), r.at(1, s)) > double{q.phi_max} ||
                                     (q.z_min > -q.radius && z < double{q.z_min}) ||
                                     (q.z_max < q.radius && z > double{q.z_max}));
      if (!cut) found.push_back(r.shift + s);
    }
  }

 protected:
  Float nearest_in_object(const ShapeTable&, const QuadricRecord& q, const ObjectRays& r) const override {
    const Float inv_a = 1.0f / length_squared(r.d);
    const Float t = -dot(r.o, r.d) * inv_a;
    const Vec3 near_it = r.at(t);
    const Float rest = -dot(near_it, r.d) * inv_a;
    const Vec3 nearest = near_it + r.d * rest;
    const Float discriminant = Float(sqr(Float(q.radius))) - length_squared(nearest);
    const Mask meets = r.active & (discriminant >= 0.0f);
    if (none(meets)) return Float(-1.0f);
    return nearest_root(r, meets, t, rest, safe_sqrt(discriminant * inv_a), nearest,
                        [&](Vec3 p) { return inside_limits(q, p); });
  }
  ObjectPoint point_in_object(const ShapeTable&, const QuadricRecord& q, Vec3 p) const override {
    ObjectPoint o;
    o.p = p * (q.radius / length(p));
    // The pole has no azimuth; any will do.
    const Mask pole = (o.p.x == 0.0f) & (o.p.y == 0.0f);
    o.p.x = select(pole, 1e-5f * q.radius, o.p.x);
    const Float phi = azimuth(o.p);
    const Float theta_min = acos(Float(q.z_min / q.radius)), theta_max = acos(Float(q.z_max / q.radius));
    const Float cos_theta = clamp(o.p.z * (1 / q.radius), -1.0f, 1.0f);
    o.uv = {phi * (1 / q.phi_max), (acos(cos_theta) - theta_min) / (theta_max - theta_min)};
    const Float z_radius = sqrt(sqr(o.p.x) + sqr(o.p.y));
    const Float inv = 1.0f / z_radius;
    o.dpdu = {o.p.y * -q.phi_max, o.p.x * q.phi_max, Float(0.0f)};
    o.dpdv = Vec3{o.p.z * o.p.x * inv, o.p.z * o.p.y * inv, -z_radius} * (theta_max - theta_min);
    o.n = o.p * (1 / q.radius);
    o.extent = q.radius;
    return o;
  }
};

}  // namespace

const ModelOf<SphereShape> sphere(ShapeKind::kSphere);

}  // namespace tessera::render::TESSERA_ISA
